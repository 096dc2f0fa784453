// Implementation of shim.h on libsumo's public headers; builds against SUMO 1.15 to 1.28.
//
// SUMO keeps its simulation in statics, so this file keeps its own state in statics as well.
#include "shim.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <exception>
#include <limits>
#include <memory>
#include <set>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include <libsumo/Lane.h>
#include <libsumo/Simulation.h>
#include <libsumo/TraCIDefs.h>
#include <libsumo/TrafficLight.h>
#include <libsumo/Vehicle.h>

namespace {

using libsumo::Lane;
using libsumo::Simulation;
using libsumo::TrafficLight;
using libsumo::Vehicle;

// Difference below which two distances along a lane are the same, metres; only rounding may
// separate them.
constexpr double SAME_DISTANCE_M = 1e-6;

// SUMO's types of signals that trains steer (TrafficLightType of all versions from 1.15 to 1.28);
// TraCIConstants.h has no names for them.
constexpr int RAIL_SIGNAL = 1;
constexpr int RAIL_CROSSING = 2;

// What is remembered of a vehicle between two calls of sumo_observe().
struct Seen {
    uint32_t number;
    uint32_t lane = std::numeric_limits<uint32_t>::max();
    // Call of sumo_observe() that saw it last.
    uint64_t call = 0;
    // Distance from the end of the lane to the next signal on the route.
    double beyond_lane_m = 0.0;
    // That signal and the vehicle's connection there, as in SumoVehicle.
    int32_t signal = -1;
    int32_t link = -1;
    uint32_t way = 0;
};

// Edges that connections lead from and to.
using Ways = std::vector<std::pair<std::string, std::string>>;

// What holds for one simulation only.
struct Episode {
    std::vector<std::string> signals;
    std::unordered_map<std::string, int32_t> signal_index;
    // By signal and position of the letter; empty where all connections have the same edges.
    std::vector<std::vector<Ways>> ways;
    std::vector<std::string> lanes;
    std::unordered_map<std::string, Seen> vehicles;
    uint64_t calls = 0;
};

bool running = false;
Episode episode;
std::string last_error;

int32_t fail(int32_t code, const std::string &text) {
    last_error = text;
    return code;
}

// Runs `body` and turns whatever it throws into a code: no exception may reach the C caller.
template <typename Body> int32_t protect(Body body) noexcept {
    try {
        body();
        return SUMO_OK;
    } catch (const libsumo::TraCIException &e) {
        return fail(SUMO_REJECTED, e.what());
    } catch (const std::exception &e) {
        return fail(SUMO_FAILED, e.what());
    } catch (...) {
        return fail(SUMO_FAILED, "an exception without a text");
    }
}

// The same for what needs a simulation; libsumo itself would dereference a null pointer.
template <typename Body> int32_t protect_running(Body body) noexcept {
    if (!running) {
        return fail(SUMO_NOT_RUNNING, "no simulation is running");
    }
    return protect(body);
}

std::vector<std::string> copied(const char *const *texts, size_t count) {
    return {texts, texts + count};
}

bool is_internal(const std::string &lane) { return lane.empty() || lane[0] == ':'; }

bool allows_cars(const std::string &lane) {
    // An unrestricted lane has an empty list of allowed classes, but so may a closed one; the
    // disallowed classes tell them apart.
    const auto disallowed = Lane::getDisallowed(lane);
    return std::none_of(disallowed.begin(), disallowed.end(), [](const std::string &name) {
        return name == "passenger" || name == "all";
    });
}

std::string edge(const std::string &lane) { return lane.substr(0, lane.rfind('_')); }

// Returns the connections of a signal that cars may use, by the position of their letter.
std::vector<std::vector<libsumo::TraCILink>> car_links(const std::string &signal) {
    auto by_index = TrafficLight::getControlledLinks(signal);
    for (auto &links : by_index) {
        const auto is_other = [](const libsumo::TraCILink &link) {
            return is_internal(link.fromLane) || is_internal(link.toLane) ||
                   !allows_cars(link.fromLane) || !allows_cars(link.toLane);
        };
        links.erase(std::remove_if(links.begin(), links.end(), is_other), links.end());
    }
    return by_index;
}

std::vector<Ways> ways_by_letter(const std::string &signal) {
    std::vector<Ways> all;
    for (const auto &links : car_links(signal)) {
        auto &ways = all.emplace_back();
        for (const auto &link : links) {
            ways.emplace_back(edge(link.fromLane), edge(link.toLane));
        }
        const auto is_first = [&](const auto &way) { return way == ways.front(); };
        if (std::all_of(ways.begin(), ways.end(), is_first)) {
            ways.clear();
        }
    }
    return all;
}

char direction(const libsumo::TraCILink &link) {
    for (const auto &connection : Lane::getLinks(link.fromLane)) {
        if (connection.approachedLane == link.toLane &&
            connection.approachedInternal == link.viaLane && connection.direction.size() == 1) {
            return connection.direction[0];
        }
    }
    return '-';
}

// Returns the phases of one ring on one side of the barrier, by name; the first two of four slots come before it.
std::vector<std::string> ring_side(const std::string &ring, size_t side) {
    std::vector<std::string> slots;
    for (const char letter : ring) {
        if (std::isdigit(static_cast<unsigned char>(letter)) != 0) {
            slots.emplace_back(1, letter);
        }
    }
    slots.resize(4, "0");
    return {slots[2 * side], slots[2 * side + 1]};
}

// Returns what two phases show together: per link the better letter.
std::string shown_together(const std::string &a, const std::string &b) {
    const std::string order = "Ggs";
    std::string state = a;
    for (size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
        if (order.find(b[i]) < order.find(a[i])) {
            state[i] = b[i];
        }
    }
    return state;
}

// Replaces the phases of a dual-ring program by what it may show, a phase of each ring on one side of the barrier:
// first those in equal places of both rings, side by side, then the others.
void pair_rings(libsumo::TraCILogic &logic) {
    const auto first = logic.subParameter.find("ring1");
    const auto second = logic.subParameter.find("ring2");
    if (first == logic.subParameter.end() || second == logic.subParameter.end()) {
        return;
    }
    const auto phase = [&](const std::string &name) -> std::shared_ptr<libsumo::TraCIPhase> {
        for (const auto &candidate : logic.phases) {
            if (candidate->name == name) {
                return candidate;
            }
        }
        return nullptr;
    };
    std::vector<std::shared_ptr<libsumo::TraCIPhase>> pairs;
    std::set<std::string> known;
    for (const bool equal : {true, false}) {
        for (size_t side = 0; side < 2; ++side) {
            const auto ring1 = ring_side(first->second, side);
            const auto ring2 = ring_side(second->second, side);
            for (size_t i = 0; i < 2; ++i) {
                for (size_t j = 0; j < 2; ++j) {
                    // An empty slot leaves the other phase of the ring green.
                    const auto a = phase(ring1[i] == "0" ? ring1[1 - i] : ring1[i]);
                    const auto b = phase(ring2[j] == "0" ? ring2[1 - j] : ring2[j]);
                    // Two phases in both rings run in step.
                    const bool apart = ring1 == ring2 && i != j;
                    if ((i == j) != equal || apart || (a == nullptr && b == nullptr)) {
                        continue;
                    }
                    const auto &one = a == nullptr ? b : a;
                    const auto &other = b == nullptr ? a : b;
                    const auto state = shown_together(one->state, other->state);
                    if (known.insert(state).second) {
                        pairs.push_back(std::make_shared<libsumo::TraCIPhase>(
                            std::max(one->duration, other->duration), state,
                            std::max(one->minDur, other->minDur),
                            std::min(one->maxDur, other->maxDur)));
                    }
                }
            }
        }
    }
    if (!pairs.empty()) {
        logic.phases = pairs;
    }
}

// Returns, row by row, which link indices meet within the junction: 1 where SUMO says so or nothing is known.
std::vector<uint8_t> meetings(const std::vector<std::vector<libsumo::TraCILink>> &by_index) {
    const size_t count = by_index.size();
    std::map<std::string, std::set<size_t>> indices;
    std::vector<std::set<std::string>> inner(count);
    std::vector<bool> is_known(count, true);
    for (size_t index = 0; index < count; ++index) {
        is_known[index] = !by_index[index].empty();
        for (const auto &link : by_index[index]) {
            std::string lane = link.viaLane;
            is_known[index] = is_known[index] && !lane.empty();
            // A lane within a junction has one way on: another such lane or the street's.
            while (!lane.empty() && inner[index].insert(lane).second) {
                indices[lane].insert(index);
                const auto next = Lane::getLinks(lane);
                lane = next.empty() ? std::string() : next.front().approachedInternal;
            }
        }
    }
    std::vector<uint8_t> meets(count * count, 0);
    for (size_t a = 0; a < count; ++a) {
        for (const auto &lane : inner[a]) {
            for (const auto &foe : Lane::getInternalFoes(lane)) {
                const auto at = indices.find(foe);
                if (at == indices.end()) {
                    continue;
                }
                for (const size_t b : at->second) {
                    meets[a * count + b] = meets[b * count + a] = 1;
                }
            }
        }
        for (size_t b = 0; b < count; ++b) {
            if (!is_known[a]) {
                meets[a * count + b] = meets[b * count + a] = 1;
            }
        }
    }
    return meets;
}

// Backs the pointers of a SumoSignal. They point into elements of the vectors, which stay where
// they are when a store is moved.
struct SignalStore {
    size_t index_count = 0;
    std::vector<libsumo::TraCILink> link_texts;
    std::vector<SumoLink> links;
    std::vector<libsumo::TraCILogic> logics;
    std::vector<std::vector<SumoPhase>> phases;
    std::vector<SumoProgram> programs;
    std::string active;
    bool railway = false;
    std::vector<uint8_t> meets;
};

// By phase 1 where a program comes to it from its first phase: by `next`, else to the following one.
std::vector<int32_t> reached(const libsumo::TraCILogic &logic) {
    const size_t count = logic.phases.size();
    std::vector<int32_t> is_reached(count, 0);
    std::vector<size_t> open;
    const auto reach = [&](size_t phase) {
        if (phase < count && is_reached[phase] == 0) {
            is_reached[phase] = 1;
            open.push_back(phase);
        }
    };
    reach(0);
    while (!open.empty()) {
        const size_t phase = open.back();
        open.pop_back();
        const auto &next = logic.phases[phase]->next;
        for (const int other : next) {
            if (other >= 0) {
                reach(static_cast<size_t>(other));
            }
        }
        if (next.empty()) {
            reach((phase + 1) % count);
        }
    }
    return is_reached;
}

// Returns the parameter `max-gap` of a program, seconds; -1 where it has none that is a number.
double max_gap_s(const libsumo::TraCILogic &logic) {
    const auto found = logic.subParameter.find("max-gap");
    if (found == logic.subParameter.end()) {
        return -1.0;
    }
    try {
        return std::stod(found->second);
    } catch (const std::exception &) {
        return -1.0;
    }
}

SignalStore describe(const std::string &signal) {
    SignalStore store;
    const auto by_index = car_links(signal);
    store.index_count = by_index.size();
    store.meets = meetings(by_index);
    std::vector<std::pair<uint32_t, char>> places;
    for (size_t index = 0; index < by_index.size(); ++index) {
        for (const auto &link : by_index[index]) {
            store.link_texts.push_back(link);
            places.emplace_back(static_cast<uint32_t>(index), direction(link));
        }
    }
    for (size_t i = 0; i < places.size(); ++i) {
        store.links.push_back({store.link_texts[i].fromLane.c_str(),
                               store.link_texts[i].toLane.c_str(), places[i].first,
                               places[i].second});
    }
    store.logics = TrafficLight::getAllProgramLogics(signal);
    std::for_each(store.logics.begin(), store.logics.end(), pair_rings);
    for (const auto &logic : store.logics) {
        auto &phases = store.phases.emplace_back();
        const auto is_reached = reached(logic);
        for (size_t i = 0; i < logic.phases.size(); ++i) {
            const auto &phase = logic.phases[i];
            phases.push_back({phase->duration, phase->minDur, phase->maxDur,
                              phase->state.c_str(), is_reached[i]});
        }
    }
    for (size_t i = 0; i < store.logics.size(); ++i) {
        store.programs.push_back({store.logics[i].programID.c_str(), store.logics[i].type,
                                  store.phases[i].data(), store.phases[i].size(),
                                  max_gap_s(store.logics[i])});
    }
    store.active = TrafficLight::getProgram(signal);
    store.railway = std::any_of(
        store.logics.begin(), store.logics.end(), [](const libsumo::TraCILogic &logic) {
            return logic.type == RAIL_SIGNAL || logic.type == RAIL_CROSSING;
        });
    return store;
}

// Remembers which of the ways with one letter the vehicle's route takes.
void choose_way(const std::string &vehicle, const Ways &ways, Seen &seen) {
    if (ways.empty()) {
        return;
    }
    const auto route = Vehicle::getRoute(vehicle);
    const auto first = static_cast<size_t>(std::max(Vehicle::getRouteIndex(vehicle), 0));
    for (size_t i = first; i + 1 < route.size(); ++i) {
        const auto way = std::find(ways.begin(), ways.end(), std::make_pair(route[i], route[i + 1]));
        if (way != ways.end()) {
            seen.way = static_cast<uint32_t>(way - ways.begin());
            return;
        }
    }
    // It takes one that is closed to cars.
    seen.link = -1;
}

// Remembers the next signal on the vehicle's route and how far it is from the end of its lane.
void look_ahead(const std::string &vehicle, double remaining_m, Seen &seen) {
    const auto signals = Vehicle::getNextTLS(vehicle);
    if (signals.empty()) {
        seen.beyond_lane_m = std::numeric_limits<double>::infinity();
        seen.signal = seen.link = -1;
        return;
    }
    const auto &next = signals.front();
    const double beyond_m = next.dist - remaining_m;
    seen.beyond_lane_m = std::abs(beyond_m) < SAME_DISTANCE_M ? 0.0 : beyond_m;
    const auto index = episode.signal_index.find(next.id);
    seen.signal = index == episode.signal_index.end() ? -1 : index->second;
    seen.link = next.tlIndex;
    seen.way = 0;
    if (seen.signal >= 0 && seen.link >= 0) {
        choose_way(vehicle, episode.ways[seen.signal].at(seen.link), seen);
    }
}

// Backs the pointers of a SumoTopology.
struct TopologyStore {
    std::vector<std::string> names;
    std::vector<std::vector<SumoPoint>> shapes;
    std::vector<SumoStreetLane> lanes;
    std::vector<SumoWay> ways;
    std::vector<uint32_t> inner;
};

uint32_t flags(const std::string &lane) {
    const auto allowed = Lane::getAllowed(lane);
    const bool foot = allowed.size() == 1 && allowed.front() == "pedestrian";
    return (allows_cars(lane) ? SUMO_LANE_CARS : 0) | (foot ? SUMO_LANE_FOOT : 0) |
           (is_internal(lane) ? SUMO_LANE_INNER : 0);
}

TopologyStore topology() {
    TopologyStore store;
    store.names = Lane::getIDList();
    std::unordered_map<std::string, uint32_t> index;
    for (const auto &name : store.names) {
        index.emplace(name, static_cast<uint32_t>(index.size()));
        auto &shape = store.shapes.emplace_back();
        for (const auto &point : Lane::getShape(name).value) {
            shape.push_back({point.x, point.y});
        }
        store.lanes.push_back({name.c_str(), Lane::getLength(name), Lane::getWidth(name),
                               flags(name), shape.data(), shape.size()});
    }
    std::set<std::pair<std::string, std::string>> controlled;
    for (const auto &signal : TrafficLight::getIDList()) {
        for (const auto &links : TrafficLight::getControlledLinks(signal)) {
            for (const auto &link : links) {
                controlled.emplace(link.fromLane, link.viaLane.empty() ? link.toLane : link.viaLane);
            }
        }
    }
    const auto is_for_cars = [&](const std::string &name) {
        return !is_internal(name) && (store.lanes[index.at(name)].flags & SUMO_LANE_CARS) != 0;
    };
    for (const auto &from : store.names) {
        if (!is_for_cars(from)) {
            continue;
        }
        for (const auto &connection : Lane::getLinks(from)) {
            const std::string &to = connection.approachedLane;
            if (to.empty() || !is_for_cars(to)) {
                continue;
            }
            std::string inner = connection.approachedInternal;
            const bool by_signal = controlled.count({from, inner.empty() ? to : inner}) != 0;
            const auto first = static_cast<uint32_t>(store.inner.size());
            // A lane within a junction has one way on: another such lane or the street's.
            while (!inner.empty()) {
                store.inner.push_back(index.at(inner));
                const auto next = Lane::getLinks(inner);
                inner = next.empty() ? std::string() : next.front().approachedInternal;
            }
            const auto count = static_cast<uint32_t>(store.inner.size()) - first;
            const auto &letter = connection.direction;
            store.ways.push_back({index.at(from), index.at(to), first, count,
                                  letter.size() == 1 ? letter[0] : '-', by_signal});
        }
    }
    return store;
}

} // namespace

const char *sumo_last_error(void) { return last_error.c_str(); }

int32_t sumo_version(int32_t *api, const char **text) {
    return protect([&] {
        static std::string name;
        const auto version = Simulation::getVersion();
        *api = version.first;
        name = version.second;
        *text = name.c_str();
    });
}

int32_t sumo_start(const char *const *argv, size_t argc) {
    if (running) {
        return fail(SUMO_REJECTED, "a simulation is already running");
    }
    const int32_t code = protect([&] {
        episode = Episode();
        Simulation::start(copied(argv, argc));
        // `--help` and the like make SUMO print something and load nothing.
        if (!Simulation::isLoaded()) {
            throw libsumo::FatalTraCIError("the options start no simulation");
        }
        running = true;
    });
    if (code != SUMO_OK) {
        // Removes the half-built network, which would otherwise meet the next start.
        const std::string reason = last_error;
        protect([] { Simulation::close(); });
        last_error = reason;
    }
    return code;
}

int32_t sumo_close(void) {
    if (!running) {
        return SUMO_OK;
    }
    running = false;
    return protect([] { Simulation::close(); });
}

int32_t sumo_step(uint32_t steps, SumoCounts *counts) {
    return protect_running([&] {
        *counts = SumoCounts{};
        for (uint32_t i = 0; i < steps; ++i) {
            Simulation::step();
            counts->teleports += static_cast<uint32_t>(Simulation::getStartingTeleportNumber());
            counts->colliding += static_cast<uint32_t>(Simulation::getCollidingVehiclesNumber());
        }
    });
}

int32_t sumo_signals(const char *const **ids, size_t *count) {
    return protect_running([&] {
        static std::vector<std::string> names;
        static std::vector<const char *> texts;
        names = TrafficLight::getIDList();
        texts.clear();
        for (const auto &name : names) {
            texts.push_back(name.c_str());
        }
        *ids = texts.data();
        *count = texts.size();
    });
}

int32_t sumo_signal(const char *signal, SumoSignal *description) {
    return protect_running([&] {
        static SignalStore store;
        store = describe(signal);
        *description = {store.index_count,     store.links.data(),    store.links.size(),
                        store.programs.data(), store.programs.size(), store.active.c_str(),
                        store.railway,         store.meets.data()};
    });
}

int32_t sumo_lane(const char *lane, SumoLane *description) {
    return protect_running([&] {
        const auto shape = Lane::getShape(lane).value;
        if (shape.size() < 2) {
            throw libsumo::TraCIException(std::string("lane ") + lane + " has no shape");
        }
        const auto &end = shape.back();
        // Some networks repeat a point; the heading needs two different ones.
        auto before = shape.rbegin() + 1;
        while (before + 1 != shape.rend() && before->x == end.x && before->y == end.y) {
            ++before;
        }
        *description = {Lane::getLength(lane), Lane::getMaxSpeed(lane), before->x, before->y,
                        end.x, end.y};
    });
}

int32_t sumo_topology(SumoTopology *description) {
    return protect_running([&] {
        static TopologyStore store;
        store = topology();
        *description = {store.lanes.data(), store.lanes.size(), store.ways.data(),
                        store.ways.size(),  store.inner.data(), store.inner.size()};
    });
}

int32_t sumo_install(const char *signal, const char *program, int32_t type,
                     const SumoPhase *phases, size_t phase_count, double max_gap_s) {
    return protect_running([&] {
        libsumo::TraCILogic logic(program, type, 0);
        if (max_gap_s >= 0.0) {
            logic.subParameter["max-gap"] = std::to_string(max_gap_s);
        }
        const size_t index_count = TrafficLight::getControlledLinks(signal).size();
        for (const auto *phase = phases; phase != phases + phase_count; ++phase) {
            // SUMO would read past the end of a short state.
            if (std::strlen(phase->state) < index_count) {
                throw libsumo::TraCIException("state " + std::string(phase->state) +
                                              " of signal " + signal + " needs " +
                                              std::to_string(index_count) + " letters");
            }
            logic.phases.push_back(std::make_shared<libsumo::TraCIPhase>(
                phase->duration_s, phase->state, phase->min_s, phase->max_s));
        }
        // SUMO would write the phases into a program of another type without a word.
        for (const auto &other : TrafficLight::getAllProgramLogics(signal)) {
            if (other.programID == program && other.type != type) {
                throw libsumo::TraCIException("signal " + std::string(signal) +
                                              " already has a program " + program +
                                              " of another type; use another id");
            }
        }
        TrafficLight::setProgramLogic(signal, logic);
        // A program that existed before is neither switched to nor reset by the call above.
        TrafficLight::setProgram(signal, program);
        TrafficLight::setPhase(signal, 0);
    });
}

int32_t sumo_show(const char *signal, const char *state) {
    return protect_running([&] {
        // SUMO would read past the end of a short state.
        const size_t index_count = TrafficLight::getControlledLinks(signal).size();
        if (std::strlen(state) < index_count) {
            throw libsumo::TraCIException("state " + std::string(state) + " of signal " + signal +
                                          " needs " + std::to_string(index_count) + " letters");
        }
        TrafficLight::setRedYellowGreenState(signal, state);
    });
}

int32_t sumo_select(const char *signal, const char *program) {
    return protect_running([&] { TrafficLight::setProgram(signal, program); });
}

int32_t sumo_watch(const char *const *signals, size_t signal_count, const char *const *lanes,
                   size_t lane_count) {
    return protect_running([&] {
        episode.signals = copied(signals, signal_count);
        episode.signal_index.clear();
        for (size_t i = 0; i < signal_count; ++i) {
            episode.signal_index.emplace(signals[i], static_cast<int32_t>(i));
        }
        episode.ways.clear();
        for (const auto &signal : episode.signals) {
            episode.ways.push_back(ways_by_letter(signal));
        }
        episode.lanes = copied(lanes, lane_count);
    });
}

int32_t sumo_enter(const char *signal, int32_t phase, double left_s) {
    return protect_running([&] {
        TrafficLight::setPhase(signal, phase);
        TrafficLight::setPhaseDuration(signal, left_s);
    });
}

int32_t sumo_set_phases(const int32_t *phases, size_t count) {
    return protect_running([&] {
        if (count != episode.signals.size()) {
            throw libsumo::TraCIException("one phase per watched signal is needed");
        }
        for (size_t i = 0; i < count; ++i) {
            if (phases[i] >= 0) {
                TrafficLight::setPhase(episode.signals[i], phases[i]);
            }
        }
    });
}

int32_t sumo_observe(SumoVehicle *vehicles, size_t capacity, size_t *count, int32_t *phases,
                     size_t phase_count) {
    bool too_small = false;
    const int32_t code = protect_running([&] {
        if (phase_count != episode.signals.size()) {
            throw libsumo::TraCIException("room for one phase per watched signal is needed");
        }
        for (size_t i = 0; i < phase_count; ++i) {
            phases[i] = TrafficLight::getPhase(episode.signals[i]);
        }
        *count = 0;
        ++episode.calls;
        for (uint32_t lane = 0; lane < episode.lanes.size(); ++lane) {
            const auto ids = Lane::getLastStepVehicleIDs(episode.lanes[lane]);
            if (ids.empty()) {
                continue;
            }
            const double length_m = Lane::getLength(episode.lanes[lane]);
            for (const auto &id : ids) {
                const auto number = static_cast<uint32_t>(episode.vehicles.size());
                Seen &seen = episode.vehicles.try_emplace(id, Seen{number}).first->second;
                const double position_m = Vehicle::getLanePosition(id);
                const double remaining_m = length_m - position_m;
                // A vehicle that was away may have come back on another part of its route.
                if (seen.lane != lane || seen.call + 1 < episode.calls) {
                    look_ahead(id, remaining_m, seen);
                    seen.lane = lane;
                }
                seen.call = episode.calls;
                if (*count < capacity) {
                    vehicles[*count] = {lane,
                                        seen.number,
                                        position_m,
                                        Vehicle::getSpeed(id),
                                        Vehicle::getWaitingTime(id),
                                        remaining_m + seen.beyond_lane_m,
                                        seen.signal,
                                        seen.link,
                                        seen.way};
                }
                ++*count;
            }
        }
        too_small = *count > capacity;
    });
    if (code == SUMO_OK && too_small) {
        return fail(SUMO_TOO_SMALL, "the vehicles do not fit into the buffer");
    }
    return code;
}

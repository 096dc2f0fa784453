// C interface to libsumo: one simulation per process, batched reads, no C++ exceptions.
//
// Every function returns one of the SUMO_* codes below; sumo_last_error() has the text of the
// last code that was not SUMO_OK. Arrays and texts that a function returns belong to the shim
// and stay valid until the same function is called again. Nothing here may be called from two
// threads at a time.
#ifndef TSC_FAMILY_SHIM_H
#define TSC_FAMILY_SHIM_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// The call did what it says.
#define SUMO_OK 0
/// SUMO refused the call, for example for an unknown id; the simulation goes on.
#define SUMO_REJECTED 1
/// SUMO failed; the simulation can only be closed. Its reason is on standard error.
#define SUMO_FAILED 2
/// No simulation is running.
#define SUMO_NOT_RUNNING 3
/// The buffer is too small; the count that was returned is the capacity that it needs.
#define SUMO_TOO_SMALL 4

/// One phase of a signal program; the durations are in seconds.
typedef struct {
    double duration_s;
    double min_s;
    double max_s;
    /// One letter per link index.
    const char *state;
    /// 1 where the program comes to it from its first phase, by `next` or else to the following one; 0 where it never
    /// does. Ignored where a program is installed.
    int32_t reached;
} SumoPhase;

/// A signal program.
typedef struct {
    const char *id;
    /// One of TRAFFICLIGHT_TYPE_*.
    int32_t type;
    const SumoPhase *phases;
    size_t phase_count;
    /// Gap between vehicles that ends a green of an actuated program, seconds; negative where no parameter says it.
    double max_gap_s;
} SumoProgram;

/// A connection that a signal controls.
typedef struct {
    const char *from;
    const char *to;
    /// Position of the connection's letter in a phase's state.
    uint32_t index;
    /// SUMO's letter for the direction; '-' when the lane lists no such connection.
    char direction;
} SumoLink;

/// A signal's connections that passenger cars may use, and its programs.
typedef struct {
    /// Number of link indices, including those that only serve pedestrians, bicycles or trains.
    size_t index_count;
    const SumoLink *links;
    size_t link_count;
    const SumoProgram *programs;
    size_t program_count;
    const char *active_program;
    /// Whether trains steer it: a level crossing or a rail signal.
    bool railway;
    /// Shape [index_count, index_count]: 1 where vehicles on connections of two link indices may meet, or nothing is known
    /// of that, as of connections that cars may not use.
    const uint8_t *meets;
} SumoSignal;

/// A lane; (x, y) are the ends of its last piece, before the stop line.
typedef struct {
    double length_m;
    double speed_mps;
    double from_x_m;
    double from_y_m;
    double to_x_m;
    double to_y_m;
} SumoLane;

/// A point of a shape.
typedef struct {
    double x_m;
    double y_m;
} SumoPoint;

/// Set in SumoStreetLane when passenger cars may use the lane.
#define SUMO_LANE_CARS 1
/// Set in SumoStreetLane when the lane is for pedestrians alone.
#define SUMO_LANE_FOOT 2
/// Set in SumoStreetLane when the lane lies within a junction.
#define SUMO_LANE_INNER 4

/// A lane of the network.
typedef struct {
    const char *id;
    double length_m;
    double width_m;
    /// Sum of SUMO_LANE_*.
    uint32_t flags;
    const SumoPoint *shape;
    size_t shape_count;
} SumoStreetLane;

/// A way through a junction that passenger cars may use, from lane to lane.
typedef struct {
    /// Indices in the list of lanes.
    uint32_t from;
    uint32_t to;
    /// Where its lanes within the junction begin in the list of inner lanes, and how many it has.
    uint32_t inner_first;
    uint32_t inner_count;
    /// SUMO's letter for the direction; '-' when it has none.
    char direction;
    /// Whether some signal controls it.
    bool controlled;
} SumoWay;

/// The lanes of the network and how cars get from one to the next.
typedef struct {
    const SumoStreetLane *lanes;
    size_t lane_count;
    const SumoWay *ways;
    size_t way_count;
    /// Indices in the list of lanes.
    const uint32_t *inner;
    size_t inner_count;
} SumoTopology;

/// Sums over the steps of one call.
typedef struct {
    uint32_t teleports;
    /// Vehicles that newly took part in a collision, so usually two per collision.
    uint32_t colliding;
} SumoCounts;

/// A vehicle on a watched lane.
typedef struct {
    /// Index of the lane in the list given to sumo_watch().
    uint32_t lane;
    /// Dense number in order of first sight, constant until the simulation is closed.
    uint32_t vehicle;
    double position_m;
    double speed_mps;
    double waiting_s;
    /// Distance to the next signal on the route, infinite if there is none.
    double distance_m;
    /// Index of that signal in the list given to sumo_watch(); -1 if there is none or it is another.
    int32_t signal;
    /// Position of the letter of the vehicle's connection at that signal; -1 if there is none.
    int32_t link;
    /// Of the signal's connections with that letter, in the order of SumoSignal, the first between the
    /// vehicle's edges.
    uint32_t way;
} SumoVehicle;

/// Returns the text that belongs to the last code other than SUMO_OK.
const char *sumo_last_error(void);

/// Returns the TraCI version and SUMO's own, such as "SUMO 1.15.0"; works without a simulation.
int32_t sumo_version(int32_t *api, const char **text);

/// Starts a simulation with the command line of the `sumo` program and its name first.
int32_t sumo_start(const char *const *argv, size_t argc);

/// Ends the simulation and writes its outputs to the end; does nothing when none is running.
int32_t sumo_close(void);

/// Simulates `steps` steps and returns what happened during them.
int32_t sumo_step(uint32_t steps, SumoCounts *counts);

/// Returns the ids of all signals.
int32_t sumo_signals(const char *const **ids, size_t *count);

/// Returns one signal's connections and programs.
int32_t sumo_signal(const char *signal, SumoSignal *description);

/// Returns one lane.
int32_t sumo_lane(const char *lane, SumoLane *description);

/// Returns the lanes of the whole network and their connections.
int32_t sumo_topology(SumoTopology *description);

/// Installs a program and runs it from its first phase; `type` is one of TRAFFICLIGHT_TYPE_*. A negative `max_gap_s` is
/// SUMO's default.
int32_t sumo_install(const char *signal, const char *program, int32_t type,
                     const SumoPhase *phases, size_t phase_count, double max_gap_s);

/// Enters a phase of the running program and ends it after `left_s` seconds.
int32_t sumo_enter(const char *signal, int32_t phase, double left_s);

/// Lets a signal show a state, one letter per link index, until it is told otherwise.
int32_t sumo_show(const char *signal, const char *state);

/// Switches a signal to another of its programs.
int32_t sumo_select(const char *signal, const char *program);

/// Sets which signals and lanes sumo_set_phases() and sumo_observe() are about.
int32_t sumo_watch(const char *const *signals, size_t signal_count, const char *const *lanes,
                   size_t lane_count);

/// Sets one phase per watched signal and restarts its timer; -1 leaves a signal alone.
int32_t sumo_set_phases(const int32_t *phases, size_t count);

/// Returns all vehicles on the watched lanes, lane by lane, and the phase of each watched signal.
int32_t sumo_observe(SumoVehicle *vehicles, size_t capacity, size_t *count, int32_t *phases,
                     size_t phase_count);

#ifdef __cplusplus
}
#endif

#endif

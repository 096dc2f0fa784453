//! Which options of somebody's SUMO configuration are used, which are left out, and which stand in the way.
//!
//! SUMO is never given the configuration itself, only the options that are known here to shape traffic and
//! to touch no file but the ones that are hashed. What SUMO would only write is left out; what would open a
//! connection or read what nobody hashes is left out with a warning. An option that nobody has looked at stands in the
//! way until its user says that it may go.
//!
//! Methods are compared on the same vehicles. So an option that ends the trips of vehicles that wait, stand or
//! collide gets [another value](replaced), with a warning: how many those are depends on the method. One that only
//! delays vehicles (`max-num-vehicles`) is used, because their delay counts, and so is one that leaves the same
//! vehicles out for every method (`scale`).
//!
//! Source: `sumo --save-template` of SUMO 1.15 with its synonyms, and of SUMO 1.28.

use super::obstacle::Accept;

/// What is done with an option.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// SUMO gets it; it shapes traffic and names no file.
    Used,
    /// A list of files that are hashed.
    Files,
    /// SUMO does not get it: it writes, prints, shows, or is decided elsewhere.
    LeftOut,
    /// SUMO does not get it either, and its user is told: what it would have done.
    Dropped(&'static str),
    /// It stands in the way until its user accepts what is done instead: what is wrong, and what to accept.
    Refused(&'static str, Accept),
}

/// Short names of options, with the long ones.
const SHORT: [(&str, &str); 13] = [
    ("n", "net-file"),
    ("net", "net-file"),
    ("r", "route-files"),
    ("routes", "route-files"),
    ("a", "additional-files"),
    ("additional", "additional-files"),
    ("w", "weight-files"),
    ("weights", "weight-files"),
    ("b", "begin"),
    ("e", "end"),
    ("s", "route-steps"),
    ("x", "weight-attribute"),
    ("measure", "weight-attribute"),
];

/// Options that are lists of files.
const FILES: [&str; 4] = ["net-file", "route-files", "additional-files", "weight-files"];

/// Options that shape traffic.
const USED: &str = "
    begin end step-length weight-attribute junction-taz precision precision.geo
    step-method.ballistic extrapolate-departpos threads lateral-resolution route-steps no-internal-links
    ignore-junction-blocker ignore-route-errors ignore-accidents collision.action collision.stoptime
    collision.check-junctions collision.check-junctions.mingap collision.mingap-factor
    intermodal-collision.action intermodal-collision.stoptime max-num-vehicles max-num-teleports scale
    scale-suffix time-to-teleport time-to-teleport.highways time-to-teleport.highways.min-speed
    time-to-teleport.disconnected time-to-teleport.remove time-to-teleport.remove-constraint
    time-to-teleport.ride time-to-teleport.bidi waiting-time-memory startup-wait-threshold max-depart-delay
    sloppy-insert eager-insert emergency-insert insertion-checks random-depart-offset keep-after-arrival
    lanechange.duration lanechange.overtake-right tls.all-off tls.actuated.show-detectors
    tls.actuated.jam-threshold tls.actuated.detector-length tls.delay_based.detector-range
    tls.yellow.min-decel railsignal-moving-block time-to-impatience default.action-step-length
    default.carfollowmodel carfollow.model default.speeddev default.emergencydecel default.departlane
    default.departspeed default.departpos overhead-wire.solver overhead-wire.recuperation
    overhead-wire.substation-current-limits emergencydecel.warning-threshold parking.maneuver
    use-stop-ended pedestrian.model pedestrian.striping.stripe-width pedestrian.striping.dawdling
    pedestrian.striping.mingap-to-vehicle pedestrian.striping.jamtime
    pedestrian.striping.jamtime.crossing pedestrian.striping.jamtime.narrow
    pedestrian.striping.reserve-oncoming pedestrian.striping.reserve-oncoming.junctions
    pedestrian.striping.legacy-departposlat pedestrian.striping.walkingarea-detail
    pedestrian.timegap-crossing ride.stop-tolerance persontrip.walk-opposite-factor routing-algorithm
    weights.random-factor weights.minor-penalty weights.tls-penalty weights.priority-factor
    weights.separate-turns persontrip.walkfactor persontrip.transfer.car-walk
    persontrip.transfer.taxi-walk persontrip.transfer.walk-taxi persontrip.default.group
    persontrip.taxi.waiting-time railway.max-train-length replay-rerouting device.rerouting.probability
    device.rerouting.explicit device.rerouting.knownveh device.rerouting.deterministic
    device.rerouting.mode device.rerouting.period device.routing.period device.rerouting.pre-period
    device.routing.pre-period device.rerouting.adaptation-weight device.routing.adaptation-weight
    device.rerouting.adaptation-steps device.routing.adaptation-steps
    device.rerouting.adaptation-interval device.routing.adaptation-interval device.rerouting.with-taz
    device.routing.with-taz with-taz device.rerouting.init-with-loaded-weights device.rerouting.threads
    routing-threads device.rerouting.synchronize device.rerouting.railsignal
    device.rerouting.bike-speeds person-device.rerouting.probability person-device.rerouting.explicit
    person-device.rerouting.knownveh person-device.rerouting.deterministic
    person-device.rerouting.period person-device.routing.period emissions.volumetric-fuel
    device.emissions.probability device.emissions.explicit device.emissions.knownveh
    device.emissions.deterministic device.emissions.begin device.emissions.period
    device.btreceiver.probability device.btreceiver.explicit device.btreceiver.knownveh
    device.btreceiver.deterministic device.btreceiver.range device.btreceiver.all-recognitions
    device.btreceiver.offtime device.btsender.probability device.btsender.explicit
    device.btsender.knownveh device.btsender.deterministic person-device.btsender.probability
    person-device.btsender.explicit person-device.btsender.knownveh person-device.btsender.deterministic
    person-device.btreceiver.probability person-device.btreceiver.explicit
    person-device.btreceiver.knownveh person-device.btreceiver.deterministic device.battery.probability
    device.battery.explicit device.battery.knownveh device.battery.deterministic
    device.battery.track-fuel device.example.probability device.example.explicit
    device.example.knownveh device.example.deterministic device.example.parameter device.ssm.probability
    device.ssm.explicit device.ssm.knownveh device.ssm.deterministic device.ssm.measures
    device.ssm.thresholds device.ssm.trajectories device.ssm.range device.ssm.extratime
    device.toc.probability device.toc.explicit device.toc.knownveh device.toc.deterministic
    device.toc.manualType device.toc.automatedType device.toc.responseTime device.toc.recoveryRate
    device.toc.lcAbstinence device.toc.initialAwareness device.toc.mrmDecel
    device.toc.dynamicToCThreshold device.toc.dynamicMRMProbability device.toc.mrmKeepRight
    device.toc.mrmSafeSpot device.toc.mrmSafeSpotDuration device.toc.maxPreparationAccel
    device.toc.ogNewTimeHeadway device.toc.ogNewSpaceHeadway device.toc.ogMaxDecel
    device.toc.ogChangeRate device.toc.useColorScheme device.driverstate.probability
    device.driverstate.explicit device.driverstate.knownveh device.driverstate.deterministic
    device.driverstate.initialAwareness device.driverstate.errorTimeScaleCoefficient
    device.driverstate.errorNoiseIntensityCoefficient
    device.driverstate.speedDifferenceErrorCoefficient device.driverstate.headwayErrorCoefficient
    device.driverstate.speedDifferenceChangePerceptionThreshold
    device.driverstate.headwayChangePerceptionThreshold device.driverstate.minAwareness
    device.driverstate.maximalReactionTime device.bluelight.probability device.bluelight.explicit
    device.bluelight.knownveh device.bluelight.deterministic device.bluelight.reactiondist
    device.fcd.probability device.fcd.explicit device.fcd.knownveh device.fcd.deterministic
    device.fcd.begin device.fcd.period device.fcd.radius person-device.fcd.probability
    person-device.fcd.explicit person-device.fcd.knownveh person-device.fcd.deterministic
    person-device.fcd.period device.elechybrid.probability device.elechybrid.explicit
    device.elechybrid.knownveh device.elechybrid.deterministic device.taxi.probability
    device.taxi.explicit device.taxi.knownveh device.taxi.deterministic device.taxi.dispatch-algorithm
    device.taxi.dispatch-algorithm.params device.taxi.dispatch-period device.taxi.idle-algorithm
    device.glosa.probability device.glosa.explicit device.glosa.knownveh device.glosa.deterministic
    device.glosa.range device.glosa.max-speedfactor device.glosa.min-speed device.vehroute.probability
    device.vehroute.explicit device.vehroute.knownveh device.vehroute.deterministic
    device.friction.probability device.friction.explicit device.friction.knownveh
    device.friction.deterministic device.friction.stdDev device.friction.offset mesosim meso-edgelength
    meso-tauff meso-taufj meso-taujf meso-taujj meso-jam-threshold meso-multi-queue meso-lane-queue
    meso-ignore-lanes-by-vclass meso.ignore-lanes.by-vclass meso-junction-control
    meso-junction-control.limited meso-tls-penalty meso-tls-flow-penalty meso-minor-penalty
    meso-overtaking meso-recheck thread-rngs
    device.bluelight.mingapfactor device.driverstate.freeSpeedErrorCoefficient
    device.glosa.add-switchtime device.glosa.ignore-cfmodel device.glosa.override-safety device.glosa.use-queue
    device.rerouting.cch-ensemble device.rerouting.cch-update-threshold.constant
    device.rerouting.cch-update-threshold.factor device.rerouting.invalidation
    device.rerouting.threshold.constant device.rerouting.threshold.factor device.ssm.exclude-conflict-types
    device.ssm.mdrac.prt device.ssm.write-na device.stationfinder.chargeType
    device.stationfinder.chargingStrategy device.stationfinder.checkEnergyForRoute
    device.stationfinder.deterministic device.stationfinder.emptyThreshold device.stationfinder.explicit
    device.stationfinder.maxDistanceToReplacedStop device.stationfinder.maxEuclideanDistance
    device.stationfinder.minOpportunityDuration device.stationfinder.needToChargeLevel
    device.stationfinder.opportunisticChargeLevel device.stationfinder.probability device.stationfinder.radius
    device.stationfinder.repeat device.stationfinder.replacePlannedStop device.stationfinder.rescueAction
    device.stationfinder.rescueTime device.stationfinder.reserveFactor
    device.stationfinder.saturatedChargeLevel device.stationfinder.waitForCharge
    device.taxi.dispatch-keep-unreachable device.taxi.vclasses mapmatch.distance mapmatch.junctions mapmatch.taz
    max-num-persons meso-interpolate-pos meso-ltm pedestrian.jupedsim.exit-tolerance pedestrian.jupedsim.model
    pedestrian.jupedsim.range-geometry-repulsion pedestrian.jupedsim.range-neighbor-repulsion
    pedestrian.jupedsim.step-length pedestrian.jupedsim.strength-geometry-repulsion
    pedestrian.jupedsim.strength-neighbor-repulsion pedestrian.striping.jamfactor
    pedestrian.striping.reserve-oncoming.max person-device.rerouting.mode person-device.rerouting.scope
    persontrip.ride-public-line railsignal.default-classes railsignal.max-block-length
    railsignal.moving-block.default-classes railsignal.moving-block.max-dist slope-centered
    time-to-teleport.railsignal-deadlock use-stop-started weights.random-factor.dynamic
    weights.reversal-penalty weights.turnaround-penalty
";

/// Options that write, print or show, or that are decided by whoever starts SUMO.
const LEFT_OUT: &str = "
    write-license output-prefix human-readable-time H netstate-dump ndump netstate netstate-output
    netstate-dump.empty-edges dump-empty-edges netstate.empty-edges netstate-dump.precision
    dump-precision netstate.precision summary tripinfo vehroutes vehroutes.exit-times
    vehroutes.last-route vehroutes.sorted vehroutes.dua vehroutes.intended-depart personroutes
    device.ssm.filter-edges.input-file device.ssm.file device.ssm.geo device.ssm.write-positions
    device.ssm.write-lane-positions device.toc.file save-configuration C save-config
    save-configuration.relative save-config.relative save-template save-schema save-commented
    save-template.commented save-state.times save-state.period save-state.period.keep
    save-state.prefix save-state.suffix save-state.files save-state.rng save-state.transportables
    save-state.constraints save-state.precision verbose v print-options xml-validation X
    xml-validation.net xml-validation.routes no-warnings W suppress-warnings aggregate-warnings log l
    log-file message-log error-log duration-log.disable no-duration-log duration-log.statistics t
    no-step-log step-log.period device.rerouting.output device.taxi.dispatch-algorithm.output
    device.taxi.idle-algorithm.output random abs-rand seed srand gui-settings-file g quit-on-end Q game G
    game.mode start S delay d breakpoints B edgedata-files data-files demo D disable-textures T
    registry-viewport window-size window-pos tracker-interval osg-view gui-testing gui-testing-debug language
    log.processid log.timestamps output-suffix output.column-header output.column-separator
    output.compression output.format write-metadata help version
";

/// What writes a file that is named like this, with its own options behind a point.
const OUTPUT: &str = "-output";

/// Options that are left out with a warning, by how they begin, and what they would have done.
const DROPPED: [(&str, &str); 10] = [
    (
        "remote-port",
        "nothing connects, and SUMO waits for nobody; what another program would steer stays as it is",
    ),
    ("num-clients", "nothing connects, and SUMO waits for nobody"),
    ("pedestrian.remote", "it would connect to another program"),
    ("pedestrian.jupedsim.wkt", "it would write a file"),
    ("pedestrian.jupedsim.py", "it would write a file"),
    ("configuration-file", "one configuration is read, this one"),
    ("astar", "its tables only make routing faster"),
    ("phemlight", "emissions are not computed"),
    ("selection-file", "only SUMO's window reads it"),
    ("device.tripinfo", "the delay of every vehicle counts"),
];

/// Options that stand in the way, by how they begin, why, and what to accept.
const REFUSED: [(&str, &str, Accept); 3] = [
    (
        "load-state",
        "a saved state is read by no controller and hashed by no run, so the streets would be empty at the start",
        Accept::EmptyStart,
    ),
    (
        "device.fcd-replay.files",
        "vehicles that follow a record take no notice of signals, so it would be left out",
        Accept::UnknownOptions,
    ),
    (
        "alternative-net-file",
        "only the first network is read, so it would be left out",
        Accept::UnknownOptions,
    ),
];

/// What is said of an option that nobody has looked at.
const UNKNOWN: &str = "it is none that is known to be safe and to shape traffic (is it spelt right?), so it would be left out";

/// What collisions do with vehicles.
const COLLISIONS: [&str; 2] = ["collision.action", "intermodal-collision.action"];

/// Values that are false for SUMO.
///
/// Source: SUMO 1.15, `StringUtils::toBool`.
const FALSE: [&str; 6] = ["0", "no", "false", "off", "-", "f"];

/// Returns the value that an option that is [used](Kind::Used) has in place of its own, and why; `None` where it keeps
/// its own.
pub fn replaced(name: &str, value: &str) -> Option<(&'static str, &'static str)> {
    let value = value.trim().to_lowercase();
    let number = value.parse::<f64>().ok();
    let is_negative = number.is_some_and(|value| value < 0.0);
    let is_false = FALSE.contains(&value.as_str());
    match name {
        "max-depart-delay" if !is_negative => Some((
            "-1",
            "it leaves vehicles that wait to enter out of the delay, and these differ between methods",
        )),
        "max-num-teleports" if !is_negative => {
            Some(("-1", "it ends a simulation early, depending on the method"))
        }
        "time-to-teleport.remove" if !is_false => Some((
            "false",
            "it ends the delay of vehicles that stand, and these differ between methods",
        )),
        "time-to-teleport.highways" if number.is_none_or(|value| value > 0.0) => {
            Some(("0", "it moves vehicles that stand, and these differ between methods"))
        }
        "time-to-teleport.disconnected" if !is_negative => {
            Some(("-1", "it moves vehicles that stand, and these differ between methods"))
        }
        name if COLLISIONS.contains(&name) && value == "remove" => Some((
            "warn",
            "it ends the delay of vehicles that collide, and these differ between methods",
        )),
        "pedestrian.model" if value == "remote" => {
            Some(("striping", "it would connect to another program"))
        }
        "mesosim" if !is_false => Some((
            "false",
            "the mesoscopic model has no lanes and no queues that a controller could see",
        )),
        "tls.all-off" if !is_false => {
            Some(("false", "it switches all signals off, so that there is nothing to control"))
        }
        _ => None,
    }
}

/// Returns what has to be accepted before an option gets its [other value](replaced); `None` where a warning is enough.
pub fn to_accept(name: &str) -> Option<Accept> {
    match name {
        "mesosim" => Some(Accept::Microscopic),
        "tls.all-off" => Some(Accept::SignalsOn),
        _ => None,
    }
}

/// Whether a value of the validation of XML is another than the one that counts.
pub fn validates(name: &str, value: &str) -> bool {
    let is_validation = name == "X" || name.starts_with("xml-validation");
    is_validation && !["never", "auto", "local"].contains(&value.trim().to_lowercase().as_str())
}

/// Returns the long name of an option, where it has a short one that counts here.
pub fn long(name: &str) -> &str {
    SHORT.iter().find(|(short, _)| *short == name).map_or(name, |(_, long)| long)
}

/// Returns what is done with an option, given its long name.
pub fn kind(name: &str) -> Kind {
    let among = |list: &str| list.split_whitespace().any(|known| known == name);
    if FILES.contains(&name) {
        return Kind::Files;
    }
    if among(USED) {
        return Kind::Used;
    }
    let is_output =
        name.split_once(OUTPUT).is_some_and(|(_, own)| own.is_empty() || own.starts_with('.'));
    if is_output || among(LEFT_OUT) {
        return Kind::LeftOut;
    }
    if let Some((_, why)) = DROPPED.iter().find(|(start, _)| name.starts_with(start)) {
        return Kind::Dropped(why);
    }
    let known = REFUSED.iter().find(|(start, ..)| name.starts_with(start));
    let (_, why, accept) = known.unwrap_or(&("", UNKNOWN, Accept::UnknownOptions));
    Kind::Refused(why, *accept)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_option_is_used_left_out_or_refused_by_its_name() {
        let kinds =
            ["scale", "route-files", "fcd-output", "fcd-output.geo", "edgedata-output", "seed"];
        assert_eq!(
            kinds.map(kind),
            [Kind::Used, Kind::Files, Kind::LeftOut, Kind::LeftOut, Kind::LeftOut, Kind::LeftOut]
        );
        for dropped in ["remote-port", "astar.all-distances", "device.tripinfo.probability"] {
            assert!(matches!(kind(dropped), Kind::Dropped(_)), "{dropped}");
        }
        for refused in ["load-state.offset", "python-script", "include", "new-outputs"] {
            assert!(matches!(kind(refused), Kind::Refused(..)), "{refused}");
        }
        assert_eq!(
            ["n", "routes", "b", "scale"].map(long),
            ["net-file", "route-files", "begin", "scale"]
        );
    }

    #[test]
    fn what_ends_trips_depending_on_the_method_gets_another_value() {
        for (name, other, replaced_ones, fine) in [
            ("max-depart-delay", "-1", &["20", "0", "0:10:00"][..], &["-1", " -1.0 "][..]),
            ("mesosim", "false", &["true", "1"], &["false"]),
            ("max-num-teleports", "-1", &["0", "9"], &["-1"]),
            ("time-to-teleport.remove", "false", &["true", "1", "x"], &["false", "OFF", "0"]),
            ("time-to-teleport.highways", "0", &["60"], &["0", "-1"]),
            ("collision.action", "warn", &["remove"], &["teleport", "warn", "none"]),
            ("intermodal-collision.action", "warn", &["remove"], &["warn"]),
            ("pedestrian.model", "striping", &["remote"], &["nonInteracting"]),
            ("max-num-vehicles", "", &[], &["20"]),
        ] {
            assert_eq!(kind(name), Kind::Used);
            for value in replaced_ones {
                assert_eq!(replaced(name, value).map(|r| r.0), Some(other), "{name}={value}");
                // What comes in its place is fine.
                assert_eq!(replaced(name, other), None, "{name}={other}");
            }
            assert!(fine.iter().all(|value| replaced(name, value).is_none()), "{name}");
        }
    }

    #[test]
    fn no_option_is_in_two_lists() {
        let all: Vec<&str> = USED.split_whitespace().chain(LEFT_OUT.split_whitespace()).collect();
        let mut once = all.clone();
        once.sort_unstable();
        once.dedup();
        assert_eq!(once.len(), all.len());
        assert!(all.iter().all(|name| long(name) == *name && !FILES.contains(name)));
    }
}

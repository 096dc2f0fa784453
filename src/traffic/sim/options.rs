//! Which options of somebody's SUMO configuration are used, which are left out, and which are refused.
//!
//! SUMO is never given the configuration itself, only the options that are known here to shape traffic and
//! to touch no file but the ones that are hashed. What SUMO would only write is left out. Every other
//! option is refused by its name: one that opens a connection or loads a state, and one that nobody has
//! looked at.
//!
//! Methods are compared on the same vehicles. So an option that ends the trips of vehicles that wait, stand or
//! collide is refused [by its value](refused_value): how many those are depends on the method. One that only
//! delays vehicles (`max-num-vehicles`) is used, because their delay counts, and so is one that leaves the same
//! vehicles out for every method (`scale`).
//!
//! Source: `sumo --save-template` of SUMO 1.15 with its synonyms, and the traffic options that later
//! versions have in their place.

/// What is done with an option.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// SUMO gets it; it shapes traffic and names no file.
    Used,
    /// A list of files that are hashed.
    Files,
    /// SUMO does not get it: it writes, prints, shows, or is decided elsewhere.
    LeftOut,
    /// The configuration cannot be used; what is wrong and the way out.
    Refused(&'static str),
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
    registry-viewport window-size window-pos tracker-interval osg-view
";

/// What writes a file that is named like this, with its own options behind a point.
const OUTPUT: &str = "-output";

/// Options that are refused, by how they begin, and why.
const REFUSED: [(&str, &str); 8] = [
    ("remote-port", "it waits for another program to connect; remove it"),
    ("num-clients", "it waits for other programs to connect; remove it"),
    ("pedestrian.remote", "it connects to another program; remove it"),
    (
        "load-state",
        "a saved state is read by no controller and hashed by no run; start without one",
    ),
    ("configuration-file", "only one configuration is read; write its options here instead"),
    ("astar", "its tables are no part of what is hashed; remove it"),
    ("phemlight", "its tables are no part of what is hashed; remove it"),
    ("device.tripinfo", "it leaves vehicles out of the delay; remove it"),
];

/// What collisions do with vehicles.
const COLLISIONS: [&str; 2] = ["collision.action", "intermodal-collision.action"];

/// Values that are false for SUMO.
///
/// Source: SUMO 1.15, `StringUtils::toBool`.
const FALSE: [&str; 6] = ["0", "no", "false", "off", "-", "f"];

/// Returns why an option that is [used](Kind::Used) may not have this value, and the way out.
pub fn refused_value(name: &str, value: &str) -> Option<&'static str> {
    let value = value.trim().to_lowercase();
    let is_negative = || value.parse::<f64>().is_ok_and(|value| value < 0.0);
    match name {
        "max-depart-delay" if !is_negative() => Some(
            "it leaves vehicles that wait to enter out of the delay, under each method others; \
             remove it or give -1",
        ),
        "max-num-teleports" if !is_negative() => {
            Some("it ends a simulation early, depending on the method; remove it or give -1")
        }
        "time-to-teleport.remove" if !FALSE.contains(&value.as_str()) => Some(
            "it ends the delay of vehicles that stand, under each method of others; remove it or \
             give false",
        ),
        "mesosim" if !FALSE.contains(&value.as_str()) => Some(
            "the mesoscopic model has no lanes and no queues that a controller could see; remove it",
        ),
        name if COLLISIONS.contains(&name) && value == "remove" => Some(
            "it ends the delay of vehicles that collide, under each method of others; remove it or \
             give another action",
        ),
        _ => None,
    }
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
    let known = REFUSED.iter().find(|(start, _)| name.starts_with(start));
    Kind::Refused(known.map_or(
        "it is not among the options that are known to be safe and to shape traffic; remove it",
        |(_, reason)| reason,
    ))
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
        for refused in
            ["remote-port", "load-state.offset", "python-script", "include", "new-outputs"]
        {
            assert!(matches!(kind(refused), Kind::Refused(_)), "{refused}");
        }
        assert_eq!(
            ["n", "routes", "b", "scale"].map(long),
            ["net-file", "route-files", "begin", "scale"]
        );
    }

    #[test]
    fn what_ends_trips_depending_on_the_method_is_refused_by_its_value() {
        for (name, refused, fine) in [
            ("max-depart-delay", &["20", "0", "0:10:00"][..], &["-1", " -1.0 "][..]),
            ("mesosim", &["true", "1"], &["false"]),
            ("max-num-teleports", &["0", "9"], &["-1"]),
            ("time-to-teleport.remove", &["true", "1", "x"], &["false", "OFF", "0"]),
            ("collision.action", &["remove"], &["teleport", "warn", "none"]),
            ("intermodal-collision.action", &["remove"], &["warn"]),
            ("max-num-vehicles", &[], &["20"]),
        ] {
            assert_eq!(kind(name), Kind::Used);
            assert!(refused.iter().all(|value| refused_value(name, value).is_some()), "{name}");
            assert!(fine.iter().all(|value| refused_value(name, value).is_none()), "{name}");
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

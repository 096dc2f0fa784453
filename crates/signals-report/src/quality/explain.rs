//! What the reasons and features on the page on quality mean, a sentence or two each.

use osm_signals::intersections::Skip;

use signals::city::reason::Reason;

/// Says what a reason means and what helps.
pub(super) fn meaning(reason: Reason) -> &'static str {
    let skip = match reason {
        Reason::OneGreen => {
            return "All streams can go at once, so no controller has anything to decide.";
        }
        Reason::NoNetwork => {
            return "Its arms allow no sound network; quality.json says what fails.";
        }
        Reason::Map(skip) => skip,
    };
    match skip {
        Skip::NotOnStreet => "Such as on a service road or a path.",
        Skip::NoJunction => "Such as at a pedestrian crossing in mid-block.",
        Skip::Border => "The junction or one of its arms is cut off: give a larger extract.",
        Skip::EndOfStreet => "Probably where the extract was cut out: give a larger one.",
        Skip::Crossing => "No other street of the junction beside it has a signal.",
        Skip::Roundabout => "It controls a roundabout, which no point MDP describes.",
        Skip::RampMeter => "It lets vehicles onto a motorway one by one: no streets cross there.",
        Skip::LevelCrossing => "It stops traffic for trains, at no junction.",
        Skip::Emergency => "It stops traffic for fire engines only.",
        Skip::Bridge => "It stops traffic before a bridge that opens.",
        Skip::SingleLane => "It lets either direction onto a single lane in turn.",
        Skip::Beacon => "It always blinks: there is nothing to control.",
        Skip::FewArms => "Such as at a bend, or where a path or a service road meets a street.",
        Skip::FewApproaches => "Only one stream arrives, so there is no green time to share.",
        Skip::ManyArms => "No network is built for it: look whether several junctions were joined.",
        Skip::ManyLanes => "Look whether the lanes in the map are right.",
        Skip::OutsideBoundary => "Left out as asked with --boundary.",
        Skip::NotListed => "Left out as asked with --signals.",
    }
}

/// Says what the values of a feature rest on.
pub(super) fn basis(feature: &str) -> &'static str {
    match feature {
        "lanes" => {
            "Known: lanes of the street. From its class: the usual number in this extract. \
             Default: streets.default_lanes."
        }
        "turn_lanes" => {
            "Known: turn:lanes of the street. Default: without marked turns no lane is for turns \
             only."
        }
        "speed" => {
            "Known: maxspeed of the street. From its class: the usual limit in this extract. \
             Default: streets.default_speed_mph."
        }
        "length" => {
            "Known: measured along the street to the next junction. Default: the extract ends \
             before it, or the length is beyond min_length_m or max_length_m."
        }
        "inflow" => {
            "Known: a traffic count along the street (--aadt). Counted on its street: on another \
             block up to counts.spread_m away. From its class: the mean of counted streets. Default: \
             traffic.default_aadt_per_lane."
        }
        _ => "",
    }
}

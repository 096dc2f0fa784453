//! Tests of how a scenario's configuration is read.

use super::*;

fn parse(options: &str) -> Result<SumoConfig, String> {
    let text = format!("<configuration>{options}</configuration>");
    SumoConfig::parse(&text, Path::new("city/a.sumocfg"))
}

#[test]
fn every_way_to_write_an_option_is_read() {
    let long = parse(
        "<net-file value='a.net'/><route-files value='a.rou, b.rou'/>\
         <additional-files value='a.add'/><begin value='5'/><end value='60'/>",
    )
    .unwrap();
    assert_eq!((long.begin_s, long.end_s, long.step_length_s), (5.0, Some(60.0), 1.0));
    let options: Vec<_> = long.options.iter().map(|(o, v)| format!("{o}={v}")).collect();
    assert_eq!(options[1], "route-files=city/a.rou,city/b.rou");
    let paths: Vec<_> = long.files.iter().map(|(_, path)| path.to_str().unwrap()).collect();
    assert_eq!(paths, ["city/a.net", "city/a.rou", "city/b.rou", "city/a.add"]);
    for other in [
        "<n v='a.net'/><r v='a.rou, b.rou'/><a v='a.add'/><b v='5'/><e v='60'/>",
        "<x><net-file>a.net</net-file><routes>a.rou,b.rou</routes></x>\
         <additional>a.add</additional> <begin>5</begin>\n<end>60</end>",
    ] {
        assert_eq!(parse(other).unwrap(), long, "{other}");
    }
}

#[test]
fn a_configuration_that_is_not_utf_8_is_refused_with_the_way_out() {
    let folder = tempfile::tempdir().unwrap();
    let config = folder.path().join("a.sumocfg");
    std::fs::write(&config, b"<c><!-- Stra\xdfe --><n v='n.xml'/></c>").unwrap();
    let e = SumoConfig::read(&config).unwrap_err();
    assert!(matches!(e, SimError::Config { .. }), "{e}");
    assert!(e.to_string().ends_with("it is no text in UTF-8; save it as UTF-8"), "{e}");
    let e = SumoConfig::parse("# A page\n", Path::new("a.sumocfg")).unwrap_err();
    assert!(e.starts_with("it is no XML"), "{e}");
}

#[test]
fn an_option_that_is_not_known_to_be_safe_is_in_the_way_and_not_passed_on() {
    for (option, expected) in [
        ("<include href='b.sumocfg' value='b'/>", "option <include>: it is none that is known"),
        ("<load-state>s.xml</load-state>", "option <load-state>: a saved state"),
        (
            "<mesosim v='1'/>",
            "option <mesosim>: 1 is taken as false: the mesoscopic model has no lanes",
        ),
        ("<r v='a'/><routes v='b'/>", "option <routes>: it is given twice; give it once"),
        (
            "<r v='${HOME}/a'/>",
            "option <r>: city/${HOME}/a: SUMO reads a comma or a variable in it; rename it",
        ),
        ("<r v='a%zz'/>", "option <r>: \"a%zz\" has a percent sign; rename it"),
        ("<step-length v='x'/>", "option <step-length>: \"x\" is not a time"),
    ] {
        let config = parse(&format!("<n v='n'/>{option}")).unwrap();
        let [obstacle] = &config.obstacles[..] else { panic!("{:?}", config.obstacles) };
        assert!(obstacle.reason.starts_with(expected), "{obstacle}");
        assert_eq!(obstacle.place, "city/a.sumocfg");
        assert!(config.options.iter().all(|(name, _)| name != "include"));
    }
}

#[test]
fn everything_in_the_way_is_found_and_what_is_replaced_is_told() {
    let config = parse(
        "<n v='n'/><include v='b'/><step-length v='x'/><remote-port v='1'/>\
         <max-depart-delay v='20'/><time-to-teleport v='300'/>",
    );
    let config = config.unwrap();
    assert_eq!(config.obstacles.len(), 2, "{:?}", config.obstacles);
    let begins: Vec<&str> =
        config.notes.iter().map(|note| note.split(':').next().unwrap()).collect();
    let expected = [
        "remote-port = 1 is left out",
        "max-depart-delay = 20 is taken as -1",
        "time-to-teleport = 300 gives way to simulation.time_to_teleport_s, by default never",
    ];
    assert_eq!(begins, expected);
    let options: Vec<_> = config.options.iter().map(|(o, v)| format!("{o}={v}")).collect();
    assert_eq!(options, ["net-file=city/n", "max-depart-delay=-1", "time-to-teleport=300"]);
}

#[test]
fn what_is_written_is_left_out_and_an_empty_value_is_none() {
    let text = "<n v='a%20b c'/><tripinfo-output value='t.xml'/><seed value='3'/><scale v=''/>";
    let config = parse(text).unwrap();
    assert_eq!(config.options, [("net-file".to_owned(), "city/a b c".to_owned())]);
}

#[test]
fn clock_times_are_read_as_sumo_reads_them() {
    let times = ["7:00:00", "1:02:03.5", "1:00:00:01", "1e2", "-1", "0:90:00"].map(seconds);
    let expected = [25_200.0, 3723.5, 86_401.0, 100.0, -1.0, 5400.0].map(Ok);
    assert_eq!(times, expected);
    for wrong in ["00:20", "20s", " 20 ", "", "inf", "1:2:3:4:5", "a:00:00"] {
        let e = seconds(wrong).unwrap_err();
        assert!(e.ends_with("is not a time; give seconds, HH:MM:SS or D:HH:MM:SS"), "{e}");
    }
}

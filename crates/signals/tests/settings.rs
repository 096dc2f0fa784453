//! Settings as a scenario of signals has them: names, replacements on the command line, messages.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

mod default_name {
    use tsc_family_signals::family::load::from_text;

    #[test]
    fn a_scenario_without_a_name_has_its_file_s_or_its_folder_s() {
        let table = "point,intersections,lanes,speed_mph,length_m,inflow_vph,left_turn_lanes,\
            right_turn_lanes\na,1,2,25,200,250,0,0\n";
        let name = |text: &str, file| {
            let loaded = from_text(text, file, &[], &|_| Ok(table.to_owned()));
            loaded.map(|l| l.scenario.name).map_err(|e| e.to_string())
        };
        let text = "[family]\npoints = \"points.csv\"\n";
        assert_eq!(name(text, "towns/my-town.toml").unwrap(), "my-town");
        assert_eq!(name(text, "towns/St. Paul.toml").unwrap(), "St--Paul");
        assert_eq!(name(text, "towns/mine/scenario.toml").unwrap(), "mine");
        assert!(name(&format!("name = \"\"\n{text}"), "a.toml").unwrap_err().contains("name"));
    }
}

mod overrides {
    use evaluation::settings::overrides::*;
    use tsc_family_signals::settings::Scenario;

    fn scenario() -> Scenario {
        toml::from_str("name = \"x\"\nfamily.points = \"p.csv\"\nbaseline.green_s = 30").unwrap()
    }

    fn applied(text: &str) -> Scenario {
        text.parse::<Override>().unwrap().apply(&scenario()).unwrap()
    }

    fn refused(text: &str) -> String {
        text.parse::<Override>().unwrap().apply(&scenario()).unwrap_err().to_string()
    }

    #[test]
    fn every_kind_of_value_can_be_given_and_the_same_changes_nothing() {
        assert_eq!(
            [applied("baseline.green_s=30.0"), applied("training={}")],
            [scenario(), scenario()]
        );
        assert_eq!(applied("idqn.learning_rate=5e-4").idqn.learning_rate, 5e-4);
        assert_eq!(applied("demand.horizon_s = 600").demand.horizon_s, 600.0);
        assert_eq!(applied("training.episodes=7").training.episodes, 7);
        assert!(applied("ippo.evaluate_mode=true").ippo.evaluate_mode);
        assert_eq!(applied("title=one = two").title, "one = two");
        assert_eq!(applied("title=").title, "");
        assert_eq!(applied("family.approaches=\"a.csv\"").family.approaches.unwrap(), "a.csv");
        let program = applied("baseline.program=equal-split").baseline.program;
        assert_eq!(program, tsc_family_signals::control::baseline::BaselineProgram::EqualSplit);
    }

    #[test]
    fn a_part_of_a_table_leaves_its_other_settings() {
        for text in ["demand.turn_shares={left=0.3}", "demand.turn_shares.left=0.3"] {
            let shares = applied(text).demand.turn_shares;
            assert_eq!((shares.left, shares.through), (0.3, 0.8), "{text}");
            let keys = text.parse::<Override>().unwrap().keys();
            assert_eq!(keys, ["demand.turn_shares.left"]);
        }
        assert_eq!(applied("family.bins.lanes=2").family.bins.speed_mph, 5.0);
    }

    #[test]
    fn an_unknown_setting_says_which_it_may_be() {
        for (text, meant) in [
            ("demand.horizon=600", "demand.horizon_s"),
            ("horizon_s=600", "demand.horizon_s"),
            ("dqn.learning_rate=1", "idqn.learning_rate"),
            ("demand={horizon=600}", "demand.horizon_s"),
        ] {
            let e = refused(text);
            assert!(e.starts_with(&format!("--set {text}: unknown setting ")), "{e}");
            assert!(e.contains(&format!("did you mean {meant}")), "{e}");
        }
    }

    #[test]
    fn a_value_of_a_wrong_type_says_what_is_expected() {
        let cases = [
            ("demand.horizon_s=soon", "expected a number, found the text \"soon\""),
            ("training.episodes=1.5", "expected a whole number from 0 to 4294967295, found 1.5"),
            ("idqn.batch_size=-3", "expected a whole number that is not negative, found -3"),
            ("ippo.evaluate_mode=1", "expected true or false, found 1"),
            ("demand=3", "expected a table, found 3"),
            ("name={a=1}", "expected a text, found a table"),
            ("demand.horizon_s.x=3", "demand.horizon_s is one value and has no settings"),
            (
                "baseline.program=netconver",
                "netconver is not one of its values auto, netconvert, equal-split; did you mean netconvert?",
            ),
        ];
        for (text, expected) in cases {
            assert_eq!(refused(text), format!("--set {text}: {expected}"));
        }
    }

    #[test]
    fn a_text_without_name_or_value_is_refused() {
        for (text, expected) in [
            ("demand.horizon_s", "expected KEY=VALUE"),
            ("=3", "empty part"),
            ("demand.=3", "empty part"),
            ("demand..horizon_s=3", "empty part"),
        ] {
            let e = text.parse::<Override>().unwrap_err();
            assert!(e.contains(expected), "{text}: {e}");
        }
    }
}

mod wording {
    use evaluation::settings::wording::*;
    use tsc_family_signals::settings::Scenario;

    fn of_file(text: &str) -> String {
        let error = toml::from_str::<Scenario>(text).unwrap_err();
        file_error::<Scenario>("c.toml", text, &error).to_string()
    }

    #[test]
    fn a_file_s_error_has_line_setting_and_plain_words() {
        let start = "name = \"x\"\nfamily.points = \"p\"\n";
        let cases = [
            (
                "[demand]\n\nhorizon = 3\n",
                "line 5: unknown setting demand.horizon; did you mean demand.horizon_s?",
            ),
            (
                "training = { episodes = 1.5 }\n",
                "line 3: training.episodes: expected a whole number from 0 to 4294967295, found 1.5",
            ),
            ("wheather = 1\n", "line 3: unknown setting wheather; there are domain, name, title,"),
        ];
        for (text, expected) in cases {
            let message = of_file(&format!("{start}{text}"));
            assert!(message.starts_with(&format!("c.toml, {expected}")), "{message}");
        }
        assert_eq!(
            of_file("name = \"x\"\n[family\n"),
            "c.toml, line 2: unclosed table, expected `]`"
        );
    }
}

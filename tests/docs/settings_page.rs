//! docs/settings.md says of every setting what its declaration says.
//!
//! `INSTA_UPDATE=always cargo test --profile quick --test docs settings_page` writes the page anew.

use std::fs;

use tsc_family::control_tasks::task::scenario::Settings;
use tsc_family::control_tasks::{
    acrobot, cartpole, half_cheetah, mountain_car, pendulum, pendulum_swing_up, quad, swimmer,
};
use tsc_family::settings::page::markdown;
use tsc_family::traffic::settings::defaults;

const PAGE: &str = "docs/settings.md";

/// Ends what is written by hand.
const MARK: &str = "<!-- from here on written by tests/docs/settings_page.rs -->\n";

/// The other sections of these have no setting that the pendulum's do not have.
fn own<S: Settings>(title: &str) -> String {
    markdown(title, &S::default().sections()[..1], None)
}

#[test]
fn the_page_of_settings_says_what_they_are() {
    let page = fs::read_to_string(PAGE).unwrap();
    let (by_hand, _) = page.split_once(MARK).expect("the page has the mark");
    let field: toml::Table =
        toml::from_str(include_str!("../../scenarios/presets/field.toml")).unwrap();
    let signals = markdown("", &defaults().sections(), Some(("field", &field)));
    let poles = markdown("CartPole: ", &cartpole::Scenario::default().sections(), None);
    let pendulums = markdown("Pendulum: ", &pendulum::Scenario::default().sections(), None);
    let others = [
        own::<mountain_car::Scenario>("Mountain car: "),
        own::<acrobot::Scenario>("Acrobot: "),
        own::<pendulum_swing_up::Scenario>("Pendulum, swung up: "),
        own::<quad::Scenario>("Quad: "),
        own::<half_cheetah::Scenario>("Half cheetah: "),
        own::<swimmer::Scenario>("Swimmer: "),
    ];
    let others = others.join("\n");
    let expected = format!(
        "{by_hand}{MARK}\n## Traffic signals\n\n{signals}\n## Carts and poles\n\n{poles}\n## Other control tasks\n\n\
         Other tasks have the sections of [their methods](control-tasks.md#run-one), with the defaults of the pendulum.\n\
         `dqn` of acrobot has the defaults of CartPole.\n\n{pendulums}\n{others}"
    );
    if std::env::var("INSTA_UPDATE").is_ok_and(|mode| mode == "always") {
        fs::write(PAGE, &expected).unwrap();
        return;
    }
    let line = page.lines().zip(expected.lines()).position(|(a, b)| a != b);
    let line = line.unwrap_or(page.lines().count().min(expected.lines().count())) + 1;
    assert!(page == expected, "{PAGE}, line {line}, is not what the settings are declared as");
}

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

#[test]
fn the_page_of_settings_says_what_they_are() {
    let page = fs::read_to_string(PAGE).unwrap();
    let (by_hand, _) = page.split_once(MARK).expect("the page has the mark");
    let field: toml::Table =
        toml::from_str(include_str!("../../scenarios/presets/field.toml")).unwrap();
    let signals = markdown("", &defaults().sections(), Some(("field", &field)));
    let poles = markdown("CartPole: ", &cartpole::Scenario::default().sections(), None);
    let pendulums = markdown("Pendulum: ", &pendulum::Scenario::default().sections(), None);
    // The other sections of these have no setting that the pendulum's do not have.
    let cars = mountain_car::Scenario::default();
    let acrobots = acrobot::Scenario::default();
    let swing_ups = pendulum_swing_up::Scenario::default();
    let quads = quad::Scenario::default();
    let cheetahs = half_cheetah::Scenario::default();
    let swimmers = swimmer::Scenario::default();
    let others = [
        markdown("Mountain car: ", &cars.sections()[..1], None),
        markdown("Acrobot: ", &acrobots.sections()[..1], None),
        markdown("Pendulum, swung up: ", &swing_ups.sections()[..1], None),
        markdown("Quad: ", &quads.sections()[..1], None),
        markdown("Half cheetah: ", &cheetahs.sections()[..1], None),
        markdown("Swimmer: ", &swimmers.sections()[..1], None),
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

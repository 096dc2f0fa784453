//! What is refused before anything is written: flags without effect, folders of other things, another run.

use std::fs;

use crate::common::{run, stderr, succeed};
use crate::outcomes::refused;

#[test]
fn what_has_no_effect_is_refused_with_the_reason() {
    let folder = tempfile::tempdir().unwrap();
    succeed(folder.path(), "build-networks smoke --quiet");
    let busy = "--sumocfg networks/smoke/busy/busy.sumocfg";
    let cases = [
        "run smoke --dry-run --sampling k-means".to_owned(),
        "run smoke --dry-run --methods max-pressure --replicates 2".to_owned(),
        "run smoke --dry-run --episodes 5".to_owned(),
        format!("run --dry-run {busy} --networks elsewhere"),
        format!("run --dry-run {busy} --budget 1 --sampling k-means"),
    ];
    let said: String = cases
        .iter()
        .map(|args| {
            let output = run(folder.path(), args);
            assert_eq!(output.status.code(), Some(2), "{args}: {}", stderr(&output));
            format!("{args}\n  {}", stderr(&output))
        })
        .collect();
    // The learners are listed where they are declared.
    insta::with_settings!({ filters => [("as idqn, .* do;", "as [learners] do;")] }, {
        insta::assert_snapshot!("without_effect", said);
    });
    for args in ["run smoke --dry-run --sampling k-means --budget 1", "run smoke -n --methods all"]
    {
        assert_eq!(stderr(&run(folder.path(), args)), "", "{args}");
    }
    let plan = succeed(folder.path(), "run smoke -n --methods all --json");
    for left_out in ["coordinated", "program", "existing"] {
        assert!(plan.contains("\"nema\"") && !plan.contains(&format!("\"{left_out}\"")), "{plan}");
    }
    succeed(folder.path(), &format!("run --dry-run {busy} --preset field --quiet"));
}

#[test]
fn a_folder_of_other_things_is_written_into_only_by_force() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("thesis")).unwrap();
    fs::write(folder.path().join("thesis/chapter.tex"), "").unwrap();
    for args in [
        "run smoke --methods baseline --eval-seeds 1 --quiet --out thesis",
        "build-networks smoke --quiet --out thesis",
        "signals busy smoke --svg thesis",
    ] {
        let output = run(folder.path(), args);
        assert_eq!(output.status.code(), Some(2), "{args}: {}", stderr(&output));
        let expected = "thesis is not empty and no ";
        assert!(stderr(&output).contains(expected), "{args}: {}", stderr(&output));
        assert!(stderr(&output).contains("or --force to write"), "{args}: {}", stderr(&output));
        assert_eq!(fs::read_dir(folder.path().join("thesis")).unwrap().count(), 1, "{args}");
    }
    let output = run(folder.path(), "run smoke --methods baseline --networks thesis --quiet");
    assert!(stderr(&output).contains("--networks thesis is not empty"), "{}", stderr(&output));
    let forced = "run smoke --methods baseline --eval-seeds 1 --quiet --out thesis --force";
    succeed(folder.path(), forced);
    succeed(folder.path(), forced.trim_end_matches(" --force"));
}

#[test]
fn a_run_with_another_network_or_table_says_which() {
    let folder = tempfile::tempdir().unwrap();
    let header = "point,intersections,lanes,speed_mph,length_m,inflow_vph,left_turn_lanes,\
                  right_turn_lanes\n";
    let table = |rows: &str| {
        fs::write(folder.path().join("p.csv"), format!("{header}{rows}")).unwrap();
    };
    let scenario = "name = \"town\"\n[family]\npoints = \"p.csv\"\n";
    fs::write(folder.path().join("town.toml"), scenario).unwrap();
    let short = "run town.toml --eval-seeds 1 --methods baseline --quiet \
                 --set demand.horizon_s=120 --out out";
    table("M\u{fc}hlstra\u{df}e / B 27,1,2,30,150,250,0,0\n");
    succeed(folder.path(), short);
    let listed = succeed(folder.path(), "list town.toml --json");
    assert!(listed.contains("\"name\":\"M\u{fc}hlstra\u{df}e / B 27\""), "{listed}");
    let refused = || {
        let output = run(folder.path(), short);
        assert_eq!(output.status.code(), Some(5), "{}", stderr(&output));
        stderr(&output)
    };
    table("M\u{fc}hlstra\u{df}e / B 27,1,4,30,150,250,0,0\n");
    let e = refused();
    assert!(e.contains("M\u{fc}hlstra\u{df}e / B 27 is another one, since the table"), "{e}");
    table("M\u{fc}hlstra\u{df}e,1,2,30,150,250,0,0\n");
    assert!(refused().contains("other point MDPs were chosen, since the table"));
}

#[test]
fn a_file_that_is_something_else_is_not_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let manifest = folder.path().join("manifest.json");
    fs::write(&manifest, "{\"kept\": true}\n").unwrap();
    let arguments = "routes smoke --point busy --seed 1 --out manifest.json";
    let e = refused(folder.path(), arguments);
    assert!(e.contains("--out manifest.json is there and is no"), "{e}");
    assert_eq!(fs::read_to_string(&manifest).unwrap(), "{\"kept\": true}\n");
    // What the command wrote itself is replaced.
    let again = arguments.replace("manifest.json", "routes.rou.xml");
    succeed(folder.path(), &again);
    succeed(folder.path(), &again);
}

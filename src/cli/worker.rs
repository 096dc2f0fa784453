//! `tsc-family worker`: one task in a process of its own.

use std::io::Read;
use std::path::PathBuf;

use crate::run::checkpoint::CHECKPOINT_EVERY_S;

/// `tsc-family worker`.
#[derive(Debug, clap::Args)]
pub struct WorkerArgs {
    /// Results directory with manifest and plan
    #[arg(value_name = "DIR")]
    pub dir: PathBuf,
    /// Row of the plan
    #[arg(long, value_name = "K")]
    pub task: usize,
    /// Folder of the networks [default: the manifest's]
    #[arg(long, value_name = "DIR")]
    pub networks: Option<PathBuf>,
    /// Which attempt at the task this is
    #[arg(long, default_value_t = 1)]
    pub attempt: u32,
    /// End when standard input closes
    #[arg(long)]
    pub watch_stdin: bool,
    /// Wall time between two checkpoints of a training, at least
    #[arg(long, value_name = "SECONDS", default_value_t = CHECKPOINT_EVERY_S)]
    pub checkpoint_every_s: u64,
}

#[cfg(feature = "libsumo")]
pub(super) fn run(args: &WorkerArgs) -> anyhow::Result<u8> {
    use std::fs;
    use std::time::Duration;

    use crate::cli::exit;
    use crate::files::FileError;
    use crate::run::error::EvalError;
    use crate::run::lab::News;
    use crate::run::task::{Workplace, perform, stops_run};
    use crate::store::Layout;
    use crate::store::manifest::{Manifest, read_plan};
    use crate::traffic::sim::libsumo::SumoSim;

    if args.watch_stdin {
        end_with_parent();
    }
    let layout = Layout::new(&args.dir);
    let manifest = Manifest::read(&layout)?;
    let plan = read_plan(&layout, &manifest.identity)?;
    let task = plan.get(args.task).ok_or_else(|| EvalError::NoTask {
        path: args.dir.clone(),
        task: args.task,
        count: plan.len(),
    })?;
    let tmp = layout.tmp();
    fs::create_dir_all(&tmp).map_err(FileError::at("create", &tmp))?;
    let scratch = tempfile::Builder::new()
        .prefix(&format!("{}.", task.task))
        .tempdir_in(&tmp)
        .map_err(FileError::at("create", &tmp))?;
    let networks =
        args.networks.clone().unwrap_or_else(|| PathBuf::from(&manifest.provenance.networks));
    let workplace = Workplace {
        layout,
        networks,
        scratch: scratch.path().to_path_buf(),
        attempt: args.attempt,
        checkpoint_every: Duration::from_secs(args.checkpoint_every_s),
    };
    let mut news = |news: News| match news {
        News::Episode(progress) => {
            let text = serde_json::to_string(&progress).expect("plain data");
            // A parent that has gone away is noticed by its closed pipe.
            let _ = super::output::line(text);
        }
        News::Note(text) => super::output::note(text),
    };
    let done = SumoSim::new()
        .map_err(EvalError::from)
        .and_then(|sim| perform(sim, &manifest, task, &workplace, &mut news));
    match done {
        Err(error) if stops_run(&error) => {
            super::output::note(format!("error: {error}"));
            Ok(exit::STOP_RUN)
        }
        done => Ok(done.map(|_| exit::DONE)?),
    }
}

#[cfg(not(feature = "libsumo"))]
pub(super) fn run(args: &WorkerArgs) -> anyhow::Result<u8> {
    let _ = (args, end_with_parent);
    Err(crate::traffic::sim::SimError::Unavailable("built without the feature `libsumo`".into())
        .into())
}

/// Ends this process when standard input closes: its parent is gone.
fn end_with_parent() {
    std::thread::spawn(|| {
        let mut buffer = [0; 64];
        while matches!(std::io::stdin().read(&mut buffer), Ok(n) if n > 0) {}
        // Not `exit`, which would run SUMO's destructors while the main thread simulates.
        let _ =
            rustix::process::kill_process(rustix::process::getpid(), rustix::process::Signal::KILL);
    });
}

//! A controller whose decisions Python makes.

use std::fs;
use std::path::Path;

use pyo3::prelude::*;
use tsc_family::nn::archive::{Archive, ArchiveError};
use tsc_family::traffic::control::{
    ControlError, Controller, Drive, GreenPhase, Observation, Setup, SignalSpec, Trainer,
};

use crate::answer::choose;
use crate::lesson::teach;
use crate::object::Object;
use crate::observation::Frame;
use crate::signals::{Sizes, signals};

/// Tensor of the bytes that `save` wrote, four in a word.
const WORDS: &str = "bytes";

/// Entry of a model's card with the number of those bytes.
const LENGTH: &str = "saved_bytes";

/// Entry of a model's card with the name of the file that they were in, within its folder.
const FILE: &str = "saved_as";

/// Name of the file that `save` and `load` get, without what they add to it.
const MODEL: &str = "model";

pub(crate) struct PyController {
    name: &'static str,
    object: Object,
    learns: bool,
    episodes: u32,
    specs: Vec<SignalSpec>,
    frame: Option<Frame>,
    model: Option<Archive>,
}

impl PyController {
    pub(crate) fn new(name: &'static str, class: &Py<PyAny>, learns: bool, setup: &Setup) -> Self {
        let (object, episodes) = (Object::new(class, setup), setup.episodes);
        Self { name, object, learns, episodes, specs: Vec::new(), frame: None, model: None }
    }

    fn own(&self, reason: String) -> ControlError {
        ControlError::Own { method: self.name, reason }
    }

    fn call<T>(
        &self,
        method: &str,
        call: impl FnOnce(&Bound<'_, PyAny>) -> PyResult<T>,
    ) -> Result<T, ControlError> {
        self.object.call(method, call).map_err(|reason| self.own(reason))
    }

    /// Keeps what the object saves of what it has learned.
    fn keep(&mut self) -> Result<(), ControlError> {
        let folder =
            tempfile::tempdir().map_err(|e| self.own(format!("no temporary folder: {e}")))?;
        let path = folder.path().join(MODEL);
        let saves = self.call("save", |object| {
            let saves = object.hasattr("save")?;
            if saves {
                object.call_method1("save", (path.as_os_str(),))?;
            }
            Ok(saves)
        })?;
        if saves {
            let model = saved(folder.path());
            self.model = Some(model.map_err(|reason| self.own(reason))?);
        }
        Ok(())
    }
}

impl Controller for PyController {
    fn name(&self) -> &'static str {
        self.name
    }

    fn begin(&mut self, specs: &[SignalSpec]) -> Result<Vec<Drive>, ControlError> {
        let sizes = Sizes::of(specs);
        let frame = self.call("begin", |object| {
            let py = object.py();
            let frame = Frame::new(py, specs, sizes)?;
            object.call_method1("begin", (signals(py, specs, sizes)?,))?;
            Ok(frame)
        })?;
        self.frame = Some(frame);
        self.specs = specs.to_vec();
        Ok(vec![Drive::Decisions; specs.len()])
    }

    fn act(
        &mut self,
        observations: &[Observation],
        phases: &mut [GreenPhase],
    ) -> Result<(), ControlError> {
        let frame = self.frame.as_ref().expect("it has begun");
        let wrong = self.call("act", |object| {
            let seen = frame.observe(object.py(), observations)?;
            let answer = object.call_method1("act", (seen,))?;
            Ok(choose(&answer, &self.specs, phases).err())
        })?;
        wrong.map_or(Ok(()), |reason| Err(self.own(format!("act returned {reason}"))))
    }

    fn train(&mut self, trainer: &mut dyn Trainer) -> Result<(), ControlError> {
        if !self.learns {
            return Ok(());
        }
        let object = self.object.get().map_err(|reason| self.own(reason))?;
        let object = Python::attach(|py| object.clone_ref(py));
        let (name, episodes) = (self.name, self.episodes);
        let loads = self.call("load", |object| object.hasattr("load"))?;
        let mut validate = |trainer: &mut dyn Trainer| {
            // What cannot be loaded again cannot be chosen: the last policy is evaluated then.
            if loads {
                self.keep()?;
            }
            trainer.validate(self)
        };
        teach(name, object, episodes, trainer, &mut validate)?;
        self.keep()
    }

    fn model(&self) -> Option<Archive> {
        self.model.clone()
    }

    fn load(&mut self, model: Archive) -> Result<(), ControlError> {
        let bytes = unpacked(&model)?;
        let folder =
            tempfile::tempdir().map_err(|e| self.own(format!("no temporary folder: {e}")))?;
        let path = folder.path().join(MODEL);
        // The name may be a stranger's.
        let name: String = model.get(FILE)?;
        let is_plain = name.starts_with(MODEL) && !name.contains(['/', '\\', '\0']);
        let name = if is_plain { name.as_str() } else { MODEL };
        fs::write(folder.path().join(name), bytes)
            .map_err(|e| self.own(format!("the model cannot be written: {e}")))?;
        self.call("load", |object| object.call_method1("load", (path.as_os_str(),)).map(drop))?;
        self.model = Some(model);
        Ok(())
    }
}

/// Returns the model of the one file in a folder. Some libraries add an ending to the path that they are given.
fn saved(folder: &Path) -> Result<Archive, String> {
    let files = fs::read_dir(folder).and_then(Iterator::collect::<Result<Vec<_>, _>>);
    let files = files.map_err(|e| format!("what save(path) wrote cannot be listed: {e}"))?;
    let [file] = files.as_slice() else {
        let count = files.len();
        return Err(format!("save(path) wrote {count} files; write one, at path"));
    };
    let bytes = fs::read(file.path());
    let bytes = bytes.map_err(|e| format!("what save(path) wrote cannot be read: {e}"))?;
    Ok(packed(&bytes, &file.file_name().to_string_lossy()))
}

fn packed(bytes: &[u8], name: &str) -> Archive {
    let word = |chunk: &[u8]| {
        let mut word = [0; 4];
        word[..chunk.len()].copy_from_slice(chunk);
        u32::from_le_bytes(word)
    };
    let words: Vec<u32> = bytes.chunks(4).map(word).collect();
    let mut archive = Archive::default();
    archive.put_u32(WORDS, &[words.len()], &words);
    archive.put(LENGTH, bytes.len());
    archive.put(FILE, name);
    archive
}

fn unpacked(archive: &Archive) -> Result<Vec<u8>, ArchiveError> {
    let length: usize = archive.get(LENGTH)?;
    let words = archive.u32(WORDS, &[length.div_ceil(4)])?;
    let mut bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
    bytes.truncate(length);
    Ok(bytes)
}

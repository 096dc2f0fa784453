//! What learning goes on from, declared once: it is written into an archive and read from one under the same names.

use crate::nn::archive::{Archive, ArchiveError};

/// Something whose state can be kept.
pub trait State {
    /// Adds the state, under names that begin with a prefix.
    fn save(&self, prefix: &str, archive: &mut Archive);

    /// Goes on from what [`Self::save`] added; fails where it is missing or of another shape.
    fn restore(&mut self, prefix: &str, archive: &Archive) -> Result<(), ArchiveError>;
}

/// Something that has learned what another of its kind can take over.
pub trait Learned {
    /// Adds what was learned, under names that begin with a prefix.
    fn learned(&self, prefix: &str, archive: &mut Archive);

    /// Takes over what [`Self::learned`] added; fails where it does not fit.
    fn load(&mut self, prefix: &str, archive: &Archive) -> Result<(), ArchiveError>;
}

macro_rules! kept {
    (State { $($fields:tt)* }) => { kept! { @both save restore { $($fields)* } } };
    (Learned { $($fields:tt)* }) => { kept! { @both learned load { $($fields)* } } };
    (@both $save:ident $restore:ident { $($name:literal: $($field:ident).+),* $(,)? }) => {
        fn $save(&self, prefix: &str, archive: &mut $crate::nn::archive::Archive) {
            $(self.$($field).+.$save(&format!("{prefix}{}", $name), archive);)*
        }

        fn $restore(
            &mut self,
            prefix: &str,
            archive: &$crate::nn::archive::Archive,
        ) -> Result<(), $crate::nn::archive::ArchiveError> {
            $(self.$($field).+.$restore(&format!("{prefix}{}", $name), archive)?;)*
            Ok(())
        }
    };
}
pub(crate) use kept;

impl State for Vec<f32> {
    fn save(&self, prefix: &str, archive: &mut Archive) {
        archive.put_f32(prefix, &[self.len()], self);
    }

    fn restore(&mut self, prefix: &str, archive: &Archive) -> Result<(), ArchiveError> {
        *self = archive.f32(prefix, &[self.len()])?;
        Ok(())
    }
}

impl State for Vec<f64> {
    fn save(&self, prefix: &str, archive: &mut Archive) {
        archive.put(prefix, self);
    }

    fn restore(&mut self, prefix: &str, archive: &Archive) -> Result<(), ArchiveError> {
        let numbers: Self = archive.get(prefix)?;
        if numbers.len() != self.len() {
            return Err(ArchiveError::Card(prefix.to_owned()));
        }
        *self = numbers;
        Ok(())
    }
}

impl<T: State> State for [T] {
    fn save(&self, prefix: &str, archive: &mut Archive) {
        let all = self.iter().enumerate();
        all.for_each(|(i, one)| one.save(&format!("{prefix}{i}."), archive));
    }

    fn restore(&mut self, prefix: &str, archive: &Archive) -> Result<(), ArchiveError> {
        let mut all = self.iter_mut().enumerate();
        all.try_for_each(|(i, one)| one.restore(&format!("{prefix}{i}."), archive))
    }
}

impl<T: Learned> Learned for [T] {
    fn learned(&self, prefix: &str, archive: &mut Archive) {
        let all = self.iter().enumerate();
        all.for_each(|(i, one)| one.learned(&format!("{prefix}{i}."), archive));
    }

    fn load(&mut self, prefix: &str, archive: &Archive) -> Result<(), ArchiveError> {
        let mut all = self.iter_mut().enumerate();
        all.try_for_each(|(i, one)| one.load(&format!("{prefix}{i}."), archive))
    }
}

macro_rules! on_the_card {
    ($($number:ty),*) => {
        $(impl State for $number {
            fn save(&self, prefix: &str, archive: &mut Archive) {
                archive.put(prefix, self);
            }

            fn restore(&mut self, prefix: &str, archive: &Archive) -> Result<(), ArchiveError> {
                *self = archive.get(prefix)?;
                Ok(())
            }
        })*
    };
}
on_the_card!(u32, u64, usize, f64);

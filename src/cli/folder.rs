//! The folder of a job: the files that its document names lie beside it, under plain names.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use rustix::fs::{Mode, OFlags};
use rustix::io::Errno;

use crate::planning::document::files::{Files, MOST_BYTES, NamedFile};
use crate::planning::finding::{Code, Finding};

/// Reads the files that the document at `job` names. What is no ordinary file is not read: a link or a folder, and
/// least of all a pipe, at which reading would not end.
#[must_use]
pub fn named_files(job: &Path, named: &[NamedFile]) -> (Files, Vec<Finding>) {
    let folder = job.parent().unwrap_or_else(|| Path::new(""));
    let (mut files, mut faults, mut seen) = (Files::default(), Vec::new(), BTreeSet::new());
    for NamedFile { at, name } in named.iter().filter(|file| seen.insert(&file.name)) {
        let read = read(&folder.join(name), MOST_BYTES - files.bytes());
        let kept =
            read.and_then(|body| files.insert(name.clone(), body).map_err(|refusal| refusal.to_string()));
        if let Err(why) = kept {
            faults.push(Finding::error(Code::UnknownFile, at.as_str(), why));
        }
    }
    (files, faults)
}

fn read(path: &Path, most: usize) -> Result<Vec<u8>, String> {
    let name = path.display();
    let file = open(path).map_err(|errno| match errno {
        Errno::LOOP => format!("{name} is a symbolic link; put the file itself beside the job"),
        Errno::NOENT => format!("there is no file {name} beside the job"),
        other => format!("cannot read {name}: {}", io::Error::from(other)),
    })?;
    let kind = file.metadata().map_err(|error| format!("cannot read {name}: {error}"))?;
    if !kind.is_file() {
        return Err(format!("{name} is not an ordinary file"));
    }
    let too_large = || format!("{name} is too large; all files together may have {MOST_BYTES} bytes");
    if kind.len() > most as u64 {
        return Err(too_large());
    }
    let mut body = Vec::new();
    // It may grow while it is read.
    let read = file.take(most as u64 + 1).read_to_end(&mut body);
    read.map_err(|error| format!("cannot read {name}: {error}"))?;
    if body.len() > most { Err(too_large()) } else { Ok(body) }
}

/// Opens the file itself, and does not wait for the other end of a pipe.
fn open(path: &Path) -> rustix::io::Result<File> {
    let flags = OFlags::RDONLY | OFlags::NOFOLLOW | OFlags::NONBLOCK | OFlags::CLOEXEC;
    Ok(File::from(rustix::fs::open(path, flags, Mode::empty())?))
}

#[cfg(test)]
mod tests {
    use super::read;

    #[test]
    fn a_file_over_the_limit_is_refused_before_and_while_it_is_read() {
        let folder = std::env::temp_dir().join(format!("bladeplan-folder-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join("x.txt");
        std::fs::write(&path, "12345").unwrap();
        assert_eq!(read(&path, 5).unwrap(), b"12345");
        assert!(read(&path, 4).unwrap_err().contains("too large"));
        // The kernel's own files say that they are empty, and are not.
        let endless = read("/proc/self/status".as_ref(), 10).unwrap_err();
        assert!(endless.contains("too large"), "{endless}");
        std::fs::remove_dir_all(&folder).unwrap();
    }
}

//! [`Budget`]: the memory that a run needs, against what it can have.
//!
//! A process that asks for too much is ended in the middle of its work, often without a word. So what is large is
//! estimated before it is made, and refused if it does not fit.

use crate::error::Error;
#[cfg(target_os = "linux")]
use std::path::{Path, PathBuf};

/// So many bytes are taken without asking whether they can be had.
const SMALL: u64 = 64 << 20;

/// What a run needs, in bytes.
#[derive(Debug, Default)]
pub struct Budget {
    /// `-max-memory`
    max: Option<u64>,
    pictures: u64,
    meshes: u64,
}

/// Bytes that can still be had, and who says so.
struct Limit {
    bytes: u64,
    from: &'static str,
}

impl Budget {
    /// Begins with nothing, and at most `max` bytes.
    pub fn new(max: Option<u64>) -> Self {
        Self { max, ..Self::default() }
    }

    /// Adds the pictures, which are made later.
    ///
    /// # Errors
    /// [`Error::Refused`] if they do not fit.
    pub fn add_pictures(&mut self, bytes: u64) -> Result<(), Error> {
        self.pictures = self.pictures.saturating_add(bytes);
        self.check("the pictures", self.pictures)
    }

    /// Adds a mesh, which is made before the next one is added.
    ///
    /// # Errors
    /// [`Error::Refused`] if it does not fit beside the pictures.
    pub fn add_mesh(&mut self, bytes: u64) -> Result<(), Error> {
        self.meshes = self.meshes.saturating_add(bytes);
        self.check("the pictures and meshes", self.pictures.saturating_add(bytes))
    }

    /// Takes back a mesh that turned out to need nothing.
    pub fn take_back_mesh(&mut self, bytes: u64) {
        self.meshes = self.meshes.saturating_sub(bytes);
    }

    /// Checks all that was added against `-max-memory`, and what is still to be made against the system's limits.
    fn check(&self, what: &str, coming: u64) -> Result<(), Error> {
        let all = self.pictures.saturating_add(self.meshes);
        let own = self.max.map(|bytes| (all, Limit { bytes, from: "-max-memory" }));
        let system = (coming > SMALL).then(limit).flatten().map(|limit| (coming, limit));
        match [own, system].into_iter().flatten().find(|(needed, limit)| *needed > limit.bytes) {
            None => Ok(()),
            Some((needed, limit)) => Err(Error::Refused(format!(
                "{what} need about {} of memory, and {} can be had ({})",
                shown(needed),
                shown(limit.bytes),
                limit.from
            ))),
        }
    }
}

/// Returns how many threads the limit of the address space allows, if there is one. Half of it is for the picture.
pub fn most_threads() -> Option<usize> {
    /// Address space of a thread: its stack, and what the allocator reserves for it.
    const THREAD: u64 = 66 << 20;
    #[cfg(target_os = "linux")]
    return address_space().map(|limit| (limit.bytes / 2 / THREAD).max(1) as usize);
    #[cfg(not(target_os = "linux"))]
    None
}

/// Returns a number of bytes as a message shows it.
pub fn shown(bytes: u64) -> String {
    match bytes {
        0..0x4000_0000 => format!("{:.1} MiB", bytes as f64 / (1 << 20) as f64),
        _ => format!("{:.2} GiB", bytes as f64 / (1 << 30) as f64),
    }
}

/// Returns the smallest limit on further memory.
#[cfg(target_os = "linux")]
fn limit() -> Option<Limit> {
    [address_space(), cgroup(), machine()].into_iter().flatten().min_by_key(|limit| limit.bytes)
}

#[cfg(not(target_os = "linux"))]
fn limit() -> Option<Limit> {
    None
}

#[cfg(target_os = "linux")]
fn address_space() -> Option<Limit> {
    use rustix::process::{Resource, getrlimit};
    let all = getrlimit(Resource::As).current?;
    let used = kibibytes("/proc/self/status", "VmSize:")?;
    Some(Limit { bytes: all.saturating_sub(used), from: "the limit of the address space, 'ulimit -v'" })
}

/// Returns the smallest limit of the control groups that the process is in. Cached files do not count: they make room.
#[cfg(target_os = "linux")]
fn cgroup() -> Option<Limit> {
    // Version 1 has a tree for each resource, version 2 one for all.
    const VERSION_1: (&str, &str, [&str; 3]) =
        (":memory:/", "/sys/fs/cgroup/memory", ["memory.limit_in_bytes", "memory.usage_in_bytes", "total_cache "]);
    const VERSION_2: (&str, &str, [&str; 3]) =
        ("0::/", "/sys/fs/cgroup", ["memory.max", "memory.current", "file "]);
    let number = |path: PathBuf| std::fs::read_to_string(path).ok()?.trim().parse::<u64>().ok();
    let groups = std::fs::read_to_string("/proc/self/cgroup").ok()?;
    let room = |(mark, root, [limit, usage, cached]): (&str, &str, [&str; 3])| {
        let (_, own) = groups.lines().find_map(|line| line.split_once(mark))?;
        let group = Path::new(root).join(own);
        let room_of = |group: &Path| {
            let (limit, used) = (number(group.join(limit))?, number(group.join(usage))?);
            let statistics = std::fs::read_to_string(group.join("memory.stat")).unwrap_or_default();
            let files = statistics.lines().find_map(|line| line.strip_prefix(cached)?.parse().ok()).unwrap_or(0);
            Some(limit.saturating_sub(used.saturating_sub(files)))
        };
        group.ancestors().take_while(|group| group.starts_with(root)).filter_map(room_of).min()
    };
    let bytes = [VERSION_1, VERSION_2].into_iter().filter_map(room).min()?;
    Some(Limit { bytes, from: "the limit of the control group" })
}

#[cfg(target_os = "linux")]
fn machine() -> Option<Limit> {
    let free = kibibytes("/proc/meminfo", "MemAvailable:")?;
    let swap = kibibytes("/proc/meminfo", "SwapFree:").unwrap_or(0);
    Some(Limit { bytes: free + swap, from: "free in this machine" })
}

/// Reads a line `key N kB` of a file; returns bytes.
#[cfg(target_os = "linux")]
fn kibibytes(file: &str, key: &str) -> Option<u64> {
    let text = std::fs::read_to_string(file).ok()?;
    let value = text.lines().find_map(|line| line.strip_prefix(key))?;
    Some(value.split_whitespace().next()?.parse::<u64>().ok()? << 10)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn everything_counts_against_the_users_limit() {
        let mut budget = Budget::new(Some(1000));
        assert!(budget.add_pictures(400).is_ok());
        assert!(budget.add_mesh(300).is_ok());
        assert!(budget.add_mesh(300).is_ok());
        let message = budget.add_mesh(1 << 20).unwrap_err().to_string();
        assert!(message.starts_with("the pictures and meshes need about 1.0 MiB of memory"), "{message}");
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn no_machine_has_an_exbibyte() {
        let message = Budget::new(None).add_pictures(1 << 60).unwrap_err().to_string();
        assert!(message.contains("1073741824.00 GiB"), "{message}");
        assert!(Budget::new(None).add_pictures(SMALL + 1).is_ok());
    }
}

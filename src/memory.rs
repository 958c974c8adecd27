//! [`Budget`]: the memory that a run needs, against what it can have.
//!
//! A process that asks for too much is ended in the middle of its work, often without a word. So what is large is
//! estimated before it is made, and refused if it does not fit. What is missed by that is the end of the process, too:
//! [`interrupt`](crate::interrupt) says the word then.

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
    cube_map: u64,
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

    /// Adds pictures, which are made later.
    ///
    /// # Errors
    /// [`Error::Refused`] if they do not fit.
    pub fn add_pictures(&mut self, bytes: u64) -> Result<(), Error> {
        self.pictures = self.pictures.saturating_add(bytes);
        self.check(0)
    }

    /// Adds a cube map, which is decoded later.
    ///
    /// # Errors
    /// [`Error::Refused`] if it does not fit beside the pictures.
    pub fn add_cube_map(&mut self, bytes: u64) -> Result<(), Error> {
        self.cube_map = self.cube_map.saturating_add(bytes);
        self.check(0)
    }

    /// Adds a mesh, which is made before the next one is added.
    ///
    /// # Errors
    /// [`Error::Refused`] if it does not fit beside the pictures.
    pub fn add_mesh(&mut self, bytes: u64) -> Result<(), Error> {
        self.meshes = self.meshes.saturating_add(bytes);
        self.check(bytes)
    }

    /// Takes back a mesh that turned out to need nothing.
    pub fn take_back_mesh(&mut self, bytes: u64) {
        self.meshes = self.meshes.saturating_sub(bytes);
    }

    /// Checks all that was added against `-max-memory`, and what is still to be made, `mesh` bytes for a mesh among it, against
    /// the system's limits.
    fn check(&self, mesh: u64) -> Result<(), Error> {
        let later = self.pictures.saturating_add(self.cube_map);
        let (all, coming) = (later.saturating_add(self.meshes), later.saturating_add(mesh));
        let own = self.max.map(|bytes| (all, Limit { bytes, from: "-max-memory" }));
        let system = limit(coming > SMALL).map(|limit| (coming, limit));
        match [own, system].into_iter().flatten().find(|(needed, limit)| *needed > limit.bytes) {
            None => Ok(()),
            Some((needed, limit)) => Err(Error::Refused(format!(
                "{} need about {} of memory, and {} can be had ({})",
                self.contents(),
                shown(needed),
                shown(limit.bytes),
                limit.from
            ))),
        }
    }

    fn contents(&self) -> &'static str {
        match (self.cube_map > 0, self.meshes > 0) {
            (false, false) => "the pictures",
            (false, true) => "the pictures and meshes",
            (true, false) => "the pictures and the cube map",
            (true, true) => "the pictures, the cube map and meshes",
        }
    }
}

/// Returns how many threads the limits of the process allow, if there are some. Half of each is for the picture.
pub fn most_threads() -> Option<usize> {
    /// Address space of a thread: its stack, and what the allocator reserves for it; and how much of that is data.
    const THREAD: [u64; 2] = [66 << 20, 3 << 20];
    #[cfg(target_os = "linux")]
    return of_process()
        .into_iter()
        .zip(THREAD)
        .filter_map(|(limit, thread)| Some((limit?.bytes / 2 / thread).max(1) as usize))
        .min();
    #[cfg(not(target_os = "linux"))]
    None
}

/// Returns a number of bytes as a message shows it.
pub fn shown(bytes: u64) -> String {
    match bytes {
        0..0x400 => format!("{bytes} bytes"),
        0x400..0x10_0000 => format!("{:.1} KiB", bytes as f64 / (1 << 10) as f64),
        0x10_0000..0x4000_0000 => format!("{:.1} MiB", bytes as f64 / (1 << 20) as f64),
        _ => format!("{:.2} GiB", bytes as f64 / (1 << 30) as f64),
    }
}

/// Returns the smallest limit on further memory. Without `all`, only those of the process.
#[cfg(target_os = "linux")]
fn limit(all: bool) -> Option<Limit> {
    let of_system = || [cgroup(), machine()];
    let limits = of_process().into_iter().chain(all.then(of_system).into_iter().flatten());
    limits.flatten().min_by_key(|limit| limit.bytes)
}

#[cfg(not(target_os = "linux"))]
fn limit(_: bool) -> Option<Limit> {
    None
}

/// Returns the limits of this process: that of the address space, and that of its part that can be written.
#[cfg(target_os = "linux")]
fn of_process() -> [Option<Limit>; 2] {
    use rustix::process::{Resource, getrlimit};
    let limit = |resource, key, from| {
        let all = getrlimit(resource).current?;
        Some(Limit { bytes: all.saturating_sub(kibibytes("/proc/self/status", key)?), from })
    };
    [
        limit(Resource::As, "VmSize:", "the limit of the address space, 'ulimit -v'"),
        limit(Resource::Data, "VmData:", "the limit of data, 'ulimit -d'"),
    ]
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
        budget.take_back_mesh(300 + (1 << 20));
        let message = budget.add_cube_map(301).unwrap_err().to_string();
        let needs =
            "the pictures, the cube map and meshes need about 1001 bytes of memory, and 1000 bytes can be had";
        assert!(message.starts_with(needs), "{message}");
    }

    #[test]
    fn sizes_are_shown_in_their_unit() {
        let sizes = [(0, "0 bytes"), (1500, "1.5 KiB"), (1 << 20, "1.0 MiB"), (3 << 29, "1.50 GiB")];
        sizes.into_iter().for_each(|(bytes, text)| assert_eq!(shown(bytes), text));
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn no_machine_has_an_exbibyte() {
        let message = Budget::new(None).add_pictures(1 << 60).unwrap_err().to_string();
        assert!(message.contains("1073741824.00 GiB"), "{message}");
        assert!(Budget::new(None).add_pictures(SMALL + 1).is_ok());
    }
}

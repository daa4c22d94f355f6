//! The caches of this machine, and the one in which a working set lives.

use std::fs;
use std::path::Path;

/// A data cache as one core sees it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Cache {
    /// 1, 2, 3.
    pub level: u8,
    /// Size \[B\]; of the whole cache where cores share it.
    pub bytes: usize,
}

/// The data and unified caches of the first core, smallest first; empty where the system does not tell.
pub fn caches() -> Vec<Cache> {
    read(Path::new("/sys/devices/system/cpu/cpu0/cache"))
}

fn read(folder: &Path) -> Vec<Cache> {
    let Ok(entries) = fs::read_dir(folder) else {
        return vec![];
    };
    let mut caches: Vec<Cache> = entries
        .filter_map(|entry| {
            let path = entry.ok()?.path();
            let field = |name: &str| fs::read_to_string(path.join(name)).ok();
            if field("type")?.trim() == "Instruction" {
                return None;
            }
            Some(Cache {
                level: field("level")?.trim().parse().ok()?,
                bytes: size(field("size")?.trim())?,
            })
        })
        .collect();
    caches.sort_by_key(|c| c.bytes);
    caches
}

/// `48K`, `1024K`, `32M` or plain bytes.
fn size(text: &str) -> Option<usize> {
    let (digits, unit) = match text.strip_suffix('K') {
        Some(digits) => (digits, 1 << 10),
        None => match text.strip_suffix('M') {
            Some(digits) => (digits, 1 << 20),
            None => (text, 1),
        },
    };
    digits.parse::<usize>().ok()?.checked_mul(unit)
}

/// `L1`, `L2`, `L3` or `DRAM`: the smallest cache that holds the working set. `unknown` where no cache is known.
pub fn regime(bytes: usize, caches: &[Cache]) -> String {
    if caches.is_empty() {
        return "unknown".to_owned();
    }
    caches
        .iter()
        .find(|c| bytes <= c.bytes)
        .map_or_else(|| "DRAM".to_owned(), |c| format!("L{}", c.level))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_working_set_lives_in_the_smallest_cache_that_holds_it() {
        let caches: Vec<Cache> = [(1, 48 << 10), (2, 1 << 20), (3, 32 << 20)]
            .map(|(level, bytes)| Cache { level, bytes })
            .to_vec();
        let at = |n: usize| regime(n, &caches);
        assert_eq!(at(24_000), "L1");
        assert_eq!(at(48 << 10), "L1");
        assert_eq!(at(240_000), "L2");
        assert_eq!(at(2_400_000), "L3");
        assert_eq!(at(240_000_000), "DRAM");
        assert_eq!(regime(1, &[]), "unknown");
    }

    #[test]
    fn sizes_of_the_kernel_are_read() {
        assert_eq!(size("48K"), Some(49_152));
        assert_eq!(size("32M"), Some(33_554_432));
        assert_eq!(size("512"), Some(512));
        assert_eq!(size("a lot"), None);
    }
}

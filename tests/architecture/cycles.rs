//! Circles in the graph of imports.

use super::imports::{Import, Imports};
use std::collections::{BTreeMap, BTreeSet};

/// For each import that lies on a circle the shortest circle through it; each circle once.
pub fn shortest(imports: &Imports) -> Vec<Vec<&Import>> {
    let mut cycles: BTreeMap<BTreeSet<(&str, &str)>, Vec<&Import>> = BTreeMap::new();
    for import in imports.iter() {
        if let Some(way_back) = shortest_way(imports, &import.to, &import.from) {
            let cycle: Vec<_> = [import].into_iter().chain(way_back).collect();
            let key = cycle.iter().map(|step| (step.from.as_str(), step.to.as_str())).collect();
            cycles.entry(key).or_insert(cycle);
        }
    }
    let mut cycles: Vec<_> = cycles.into_values().collect();
    cycles.sort_by_key(Vec::len);
    cycles
}

fn shortest_way<'a>(imports: &'a Imports, from: &'a str, to: &str) -> Option<Vec<&'a Import>> {
    let mut ways: Vec<(&str, Vec<&Import>)> = vec![(from, Vec::new())];
    let mut seen = BTreeSet::from([from]);
    while !ways.is_empty() {
        let mut longer = Vec::new();
        for (end, way) in ways {
            if end == to {
                return Some(way);
            }
            for step in imports.iter().filter(|step| step.from == end) {
                if seen.insert(&step.to) {
                    longer.push((step.to.as_str(), way.iter().copied().chain([step]).collect()));
                }
            }
        }
        ways = longer;
    }
    None
}

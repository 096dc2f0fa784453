//! Which methods a growing sample can do without.

use super::Until;

/// Two methods that are compared at a look.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Compared<T> {
    /// The methods.
    pub methods: [T; 2],
    /// Which of them is ahead by more than chance, if one is.
    pub ahead: Option<T>,
}

/// Returns the methods that say nothing more about what is open, each with one that is ahead of it: for the first place
/// those that are behind another one, else those of which all pairs are decided and one says that they are behind.
///
/// # Arguments
///
/// * `compared` — the pairs that are asked about, of methods that are still evaluated; for the first place all of them.
pub fn behind<T: Copy + PartialEq>(until: &Until, compared: &[Compared<T>]) -> Vec<(T, T)> {
    let mut methods: Vec<T> = Vec::new();
    for method in compared.iter().flat_map(|pair| pair.methods) {
        if !methods.contains(&method) {
            methods.push(method);
        }
    }
    let needed = |pairs: &[&Compared<T>]| match until {
        Until::Decided(_) => pairs.iter().any(|pair| pair.ahead.is_none()),
        Until::FirstPlace(_) => false,
    };
    let of = |method: T| {
        let own: Vec<_> = compared.iter().filter(|pair| pair.methods.contains(&method)).collect();
        let rival = own.iter().find_map(|pair| pair.ahead.filter(|ahead| *ahead != method))?;
        (!needed(&own)).then_some((method, rival))
    };
    methods.into_iter().filter_map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_keep_whom_they_need_and_the_first_place_only_those_that_may_have_it() {
        // a is ahead of c, and c of d; what b is to others is open.
        let pair = |methods: [char; 2], ahead: Option<char>| Compared { methods, ahead };
        let all = [
            pair(['a', 'b'], None),
            pair(['a', 'c'], Some('a')),
            pair(['b', 'c'], None),
            pair(['c', 'd'], Some('c')),
        ];
        assert_eq!(behind(&Until::FirstPlace(vec![]), &all), [('c', 'a'), ('d', 'c')]);
        assert_eq!(behind(&Until::Decided(vec![]), &all), [('d', 'c')]);
    }
}

//! Maximum of every window of a series, in one pass: the ascending minima of Lemire, *Streaming maximum-minimum filter
//! using no more than three comparisons per element*, 2006.

use std::collections::VecDeque;

/// Returns the maximum of `series[place ..= place + reach]` for each place, as far as the series goes.
pub(super) fn largest_ahead<T: Ord + Copy>(series: &[T], reach: usize) -> Vec<T> {
    // Places whose value is larger than all that come after them in the window; the maximum is at the front.
    let mut wedge: VecDeque<usize> = VecDeque::new();
    let mut largest = Vec::with_capacity(series.len());
    let mut end = 0;
    for start in 0..series.len() {
        while end < series.len() && end - start <= reach {
            while wedge.back().is_some_and(|&k| series[k] <= series[end]) {
                wedge.pop_back();
            }
            wedge.push_back(end);
            end += 1;
        }
        while wedge.front().is_some_and(|&k| k < start) {
            wedge.pop_front();
        }
        largest.extend(wedge.front().map(|&k| series[k]));
    }
    largest
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::largest_ahead;

    proptest! {
        #[test]
        fn it_is_the_largest(series in proptest::collection::vec(0_u8..10, 0..40), reach in 0_usize..50) {
            let brute: Vec<u8> = (0..series.len())
                .map(|i| series[i..series.len().min(i + reach + 1)].iter().copied().max().unwrap())
                .collect();
            prop_assert_eq!(largest_ahead(&series, reach), brute);
        }
    }
}

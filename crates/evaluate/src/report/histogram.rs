//! Quantiles of histograms.

/// Returns evenly spaced quantiles of a histogram, each as its bin and the share of the bin that is below it.
pub(super) fn quantiles(shares: &[f64], count: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
    let total: f64 = shares.iter().sum();
    let (mut bin, mut sum) = (0, shares.first().copied().unwrap_or_default());
    (0..count).map(move |index| {
        let wanted = (index as f64 + 0.5) / count as f64 * total;
        while sum < wanted && bin + 1 < shares.len() {
            bin += 1;
            sum += shares[bin];
        }
        let within = if shares[bin] > 0.0 { 1.0 - (sum - wanted) / shares[bin] } else { 0.5 };
        (bin, within.clamp(0.0, 1.0))
    })
}

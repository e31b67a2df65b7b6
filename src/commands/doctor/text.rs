//! The examination as a person reads it.

use std::fmt::Write;

use uarm_io::finding::{Finding, Verdict};
use uarm_io::probe::{LatencyBucket, WakeupReport};

use super::examination::Examination;

/// Width of the histogram's longest bar, characters.
const BAR: u64 = 50;

/// The whole report.
pub(super) fn examination(examination: &Examination) -> String {
    let mut text = String::new();
    section(&mut text, "Real time", &examination.realtime);
    section(&mut text, "CAN", &examination.can);
    if !examination.robot.is_empty() {
        section(&mut text, "Robot file", &examination.robot);
    }
    wakeups(&mut text, &examination.wakeups);
    let all = examination.realtime.iter().chain(&examination.can).chain(&examination.robot);
    let judged = |verdict| all.clone().filter(|finding| finding.verdict == verdict).count();
    let (bad, warnings) = (judged(Verdict::Bad), judged(Verdict::Warning));
    let verdict = match examination.verdict {
        Verdict::Good => "this machine is ready",
        Verdict::Warning => "this machine can run the loop, with less margin than it could have",
        Verdict::Bad => "this machine is not ready",
    };
    line(
        &mut text,
        format_args!("{verdict}; above: {bad} bad, {warnings} to improve; wake-ups: {}", examination.wakeups.verdict),
    );
    text
}

/// Writing to a `String` cannot fail.
fn line(text: &mut String, arguments: std::fmt::Arguments<'_>) {
    let _ = text.write_fmt(arguments);
    text.push('\n');
}

fn section(text: &mut String, title: &str, findings: &[Finding]) {
    line(text, format_args!("{title}"));
    for finding in findings {
        line(text, format_args!("  {:<7}  {:<28} {}", mark(finding.verdict), finding.name, finding.found));
        if finding.verdict != Verdict::Good {
            line(text, format_args!("{:11}wanted: {}", "", finding.wanted));
            line(text, format_args!("{:11}how:    {}", "", finding.how_to_get_it));
        }
    }
    text.push('\n');
}

/// What is bad stands out without colours, in a pipe too.
const fn mark(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Good => "good",
        Verdict::Warning => "warning",
        Verdict::Bad => "BAD",
    }
}

fn wakeups(text: &mut String, report: &WakeupReport) {
    let period = duration(report.period_nanoseconds);
    line(text, format_args!("Wake-ups every {period}, {} of them, unfiltered", report.samples));
    for item in &report.realtime {
        line(text, format_args!("  {:<7}  {:<32} {}", mark(item.verdict), item.name, item.found));
    }
    text.push('\n');
    histogram(text, &report.buckets);
    line(
        text,
        format_args!(
            "  min {}, mean {}, p99 {}, p99.9 {}, max {}; {} of {} came a whole period late; page faults {} minor, {} major",
            duration(report.minimum_nanoseconds),
            microseconds(report.mean_nanoseconds),
            duration(report.p99_nanoseconds),
            duration(report.p999_nanoseconds),
            duration(report.maximum_nanoseconds),
            report.missed,
            report.samples,
            report.page_faults.0,
            report.page_faults.1,
        ),
    );
    line(
        text,
        format_args!("  {}: the largest is {} of the period{}", mark(report.verdict), share(report), advice(report)),
    );
    text.push('\n');
}

fn advice(report: &WakeupReport) -> String {
    if report.advice.is_empty() { String::new() } else { format!("; {}", report.advice) }
}

fn share(report: &WakeupReport) -> String {
    format!("{:.1} %", 100.0 * report.maximum_nanoseconds as f64 / report.period_nanoseconds as f64)
}

/// Bars from the first to the last bucket that holds anything; the rarest wake-up, which is the one that matters, is seen.
fn histogram(text: &mut String, buckets: &[LatencyBucket]) {
    let filled = |bucket: &LatencyBucket| bucket.count > 0;
    let (Some(first), Some(last)) = (buckets.iter().position(filled), buckets.iter().rposition(filled)) else { return };
    let most = buckets.iter().map(|bucket| bucket.count).max().unwrap_or(0).max(1);
    for bucket in &buckets[first..=last] {
        let edge = bucket.up_to_nanoseconds.map_or_else(|| "more".to_owned(), |edge| format!("≤ {}", duration(edge)));
        let bar = "█".repeat((bucket.count.saturating_mul(BAR).div_ceil(most)) as usize);
        line(text, format_args!("  {edge:>10}  {:>9}  {bar}", bucket.count));
    }
}

fn microseconds(nanoseconds: f64) -> String {
    format!("{:.1} µs", nanoseconds / 1e3)
}

/// A span in the unit that keeps it short.
fn duration(nanoseconds: u64) -> String {
    match nanoseconds {
        0..1_000 => format!("{nanoseconds} ns"),
        1_000..1_000_000 => with_unit(nanoseconds, 1_000, "µs"),
        1_000_000..1_000_000_000 => with_unit(nanoseconds, 1_000_000, "ms"),
        _ => with_unit(nanoseconds, 1_000_000_000, "s"),
    }
}

fn with_unit(nanoseconds: u64, unit: u64, name: &str) -> String {
    if nanoseconds.is_multiple_of(unit) {
        format!("{} {name}", nanoseconds / unit)
    } else {
        format!("{:.1} {name}", nanoseconds as f64 / unit as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spans_are_short() {
        for (nanoseconds, text) in
            [(0, "0 ns"), (999, "999 ns"), (3_000_000, "3 ms"), (12_345, "12.3 µs"), (2_500_000_000, "2.5 s")]
        {
            assert_eq!(duration(nanoseconds), text);
        }
    }

    #[test]
    fn a_single_outlier_is_seen() {
        let bucket = |up_to_nanoseconds, count| LatencyBucket { up_to_nanoseconds, count };
        let mut text = String::new();
        histogram(
            &mut text,
            &[bucket(Some(1_000), 0), bucket(Some(2_000), 1_000_000), bucket(Some(5_000), 0), bucket(None, 1)],
        );
        let bars: Vec<_> = text.lines().map(|line| line.matches('█').count()).collect();
        assert_eq!(bars, [50, 0, 1], "{text}");
        assert!(text.ends_with("more          1  █\n"), "{text}");
    }

    #[test]
    fn only_what_is_missing_gets_advice() {
        let finding = |verdict| Finding {
            name: "governor".into(),
            found: "powersave".into(),
            wanted: "performance".into(),
            verdict,
            how_to_get_it: "cpupower".into(),
        };
        let mut text = String::new();
        section(&mut text, "Real time", &[finding(Verdict::Good)]);
        assert!(text.contains("good     governor") && !text.contains("cpupower"), "{text}");
        section(&mut text, "Real time", &[finding(Verdict::Bad)]);
        assert!(text.contains("BAD      governor") && text.contains("how:    cpupower"), "{text}");
    }
}

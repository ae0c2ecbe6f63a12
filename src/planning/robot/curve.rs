//! The joints over time: thinned as they come, and written as CSV.

use crate::planning::program::number::fixed;
use crate::planning::program::robot_moves::Joints;
use crate::planning::tolerance::JOINT_CURVE_DEG;

/// The joints at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointSample {
    /// s since the path began.
    pub time_s: f64,
    /// Degrees.
    pub joints: Joints,
}

/// The most samples of a curve: a few MB of CSV. A longer one is thinned out further.
const MOST_SAMPLES: usize = 100_000;

/// Takes samples in order of time and keeps those between which straight lines miss none of the others by more than
/// a tolerance (a cone test: from the last kept sample, every joint's slope has to pass all samples since).
#[derive(Debug, Clone)]
pub struct Curve {
    tolerance_deg: f64,
    most: usize,
    kept: Vec<JointSample>,
    /// The newest sample, if it is not kept yet.
    newest: Option<JointSample>,
    slopes: [(f64, f64); 6],
}

const ANY_SLOPE: [(f64, f64); 6] = [(f64::NEG_INFINITY, f64::INFINITY); 6];
const NO_SLOPE: [(f64, f64); 6] = [(f64::INFINITY, f64::NEG_INFINITY); 6];

impl Default for Curve {
    fn default() -> Self {
        Self::new(JOINT_CURVE_DEG, MOST_SAMPLES)
    }
}

impl Curve {
    /// A curve thinned out to `tolerance_deg`, or further where it would otherwise have more than `most` samples.
    #[must_use]
    pub fn new(tolerance_deg: f64, most: usize) -> Self {
        Self { tolerance_deg, most: most.max(2), kept: Vec::new(), newest: None, slopes: ANY_SLOPE }
    }

    /// Takes the next sample.
    pub fn push(&mut self, sample: JointSample) {
        let Some(anchor) = self.kept.last().copied() else {
            return self.kept.push(sample);
        };
        if self.newest.is_some() && !self.passes(&anchor, &sample) {
            self.keep_newest();
            return self.push(sample);
        }
        self.narrow(&anchor, &sample);
        self.newest = Some(sample);
    }

    /// The samples kept, the last one among them.
    #[must_use]
    pub fn finish(mut self) -> Vec<JointSample> {
        self.keep_newest();
        self.kept
    }

    fn passes(&self, anchor: &JointSample, sample: &JointSample) -> bool {
        let seconds = sample.time_s - anchor.time_s;
        let within = |i: usize| {
            let slope = (sample.joints[i] - anchor.joints[i]) / seconds;
            (self.slopes[i].0..=self.slopes[i].1).contains(&slope)
        };
        seconds > 0.0 && (0..6).all(within)
    }

    fn narrow(&mut self, anchor: &JointSample, sample: &JointSample) {
        let seconds = sample.time_s - anchor.time_s;
        if seconds <= 0.0 && sample.joints != anchor.joints {
            // A jump: no line from the anchor passes it.
            self.slopes = NO_SLOPE;
        } else if seconds > 0.0 {
            for (i, (low, high)) in self.slopes.iter_mut().enumerate() {
                let change = sample.joints[i] - anchor.joints[i];
                *low = low.max((change - self.tolerance_deg) / seconds);
                *high = high.min((change + self.tolerance_deg) / seconds);
            }
        }
    }

    fn keep_newest(&mut self) {
        self.kept.extend(self.newest.take());
        self.slopes = ANY_SLOPE;
        if self.kept.len() > self.most {
            self.thin_further();
        }
    }

    /// Thins out what is kept to twice the tolerance. Errors add up to at most twice the last tolerance.
    fn thin_further(&mut self) {
        let mut thinner = Self::new(self.tolerance_deg * 2.0, usize::MAX);
        self.kept.drain(..).for_each(|sample| thinner.push(sample));
        self.tolerance_deg = thinner.tolerance_deg;
        self.kept = thinner.finish();
    }
}

/// A curve as CSV: `time_s,a1_deg,..,a6_deg`, a line a sample.
#[must_use]
pub fn csv(samples: &[JointSample]) -> String {
    /// Of a time: a tenth of a millisecond, the cycle of no control.
    const TIME_DECIMALS: usize = 4;
    /// Of an angle, as in programs.
    const ANGLE_DECIMALS: usize = 4;
    let mut text = String::from("time_s,a1_deg,a2_deg,a3_deg,a4_deg,a5_deg,a6_deg\n");
    for sample in samples {
        text.push_str(&fixed(sample.time_s, TIME_DECIMALS));
        for joint in sample.joints {
            text.push(',');
            text.push_str(&fixed(joint, ANGLE_DECIMALS));
        }
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(count: usize) -> Vec<JointSample> {
        let sample = |i: usize| {
            let time_s = i as f64 * 0.01;
            let joints = std::array::from_fn(|j| 40.0 * (time_s * (1.0 + 0.3 * j as f64)).sin());
            JointSample { time_s, joints }
        };
        (0..count).map(sample).collect()
    }

    fn thinned(samples: &[JointSample], tolerance: f64, most: usize) -> Vec<JointSample> {
        let mut curve = Curve::new(tolerance, most);
        samples.iter().for_each(|sample| curve.push(*sample));
        curve.finish()
    }

    fn worst_miss(samples: &[JointSample], kept: &[JointSample]) -> f64 {
        let mut worst = 0.0_f64;
        for pair in kept.windows(2) {
            for sample in samples.iter().filter(|s| (pair[0].time_s..=pair[1].time_s).contains(&s.time_s)) {
                let share = (sample.time_s - pair[0].time_s) / (pair[1].time_s - pair[0].time_s);
                for i in 0..6 {
                    let line = pair[0].joints[i] + share * (pair[1].joints[i] - pair[0].joints[i]);
                    worst = worst.max((line - sample.joints[i]).abs());
                }
            }
        }
        worst
    }

    #[test]
    fn no_dropped_sample_is_missed_by_more_than_the_tolerance() {
        let samples = wave(2000);
        let kept = thinned(&samples, 0.1, 10_000);
        assert_eq!((kept[0], kept[kept.len() - 1]), (samples[0], samples[1999]));
        assert!(worst_miss(&samples, &kept) <= 0.1 + 1e-12);
        assert!(kept.len() < 400, "{} kept", kept.len());
    }

    #[test]
    fn a_curve_too_long_is_thinned_out_further_and_still_follows() {
        let samples = wave(20_000);
        let kept = thinned(&samples, 1e-3, 500);
        assert!(kept.len() <= 501, "{} kept", kept.len());
        assert_eq!(kept[kept.len() - 1], samples[19_999]);
        assert!(worst_miss(&samples, &kept) < 30.0);
    }

    #[test]
    fn a_jump_in_no_time_keeps_both_its_ends() {
        let at = |time_s, angle| JointSample { time_s, joints: [angle; 6] };
        let samples = [at(0.0, 0.0), at(1.0, 1.0), at(1.0, 9.0), at(2.0, 10.0)];
        assert_eq!(thinned(&samples, 0.1, 100), samples);
    }

    #[test]
    fn the_csv_has_a_head_and_a_line_a_sample() {
        let samples = [
            JointSample { time_s: 0.0, joints: [0.0, -90.0, 90.0, 0.0, -0.000_04, 0.0] },
            JointSample { time_s: 1.25, joints: [1.5; 6] },
        ];
        let expected = "time_s,a1_deg,a2_deg,a3_deg,a4_deg,a5_deg,a6_deg\n\
                        0.0,0.0,-90.0,90.0,0.0,0.0,0.0\n1.25,1.5,1.5,1.5,1.5,1.5,1.5\n";
        assert_eq!(csv(&samples), expected);
    }
}

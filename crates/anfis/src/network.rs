//! Layers 1 to 3 of Jang's network: memberships, firing strengths, normalised firing strengths.

use nalgebra::ComplexField;

use crate::bell::Bell;
use crate::data::DataSet;
use crate::premises::{Firing, PremiseSets};

/// The rule grid with its bells in one row, as the training walks through it.
#[derive(Clone, Debug)]
pub(crate) struct Network {
    pub firing: Firing,
    pub bells: Vec<Bell>,
    /// Per rule and input the index of its bell.
    premises: Vec<usize>,
    /// Per bell the index of its input.
    input_of_bell: Vec<usize>,
    inputs: usize,
}

/// What layers 1 and 3 make of a data set.
pub(crate) struct Fired {
    /// Per sample and bell the membership, or its logarithm for a sample that no rule reaches: its order is the same.
    pub grades: Vec<f64>,
    /// Per sample and rule the normalised firing strength.
    pub strengths: Vec<f64>,
}

impl Network {
    pub fn new(sets: &PremiseSets) -> Self {
        let counts = sets.inputs().iter().map(|input| input.sets().len());
        let offsets: Vec<usize> = counts
            .scan(0, |next, count| {
                *next += count;
                Some(*next - count)
            })
            .collect();
        let premises = (0..sets.rules()).flat_map(|rule| sets.rule(rule).zip(&offsets).map(|(set, first)| first + set));
        let input_of_bell = sets.inputs().iter().enumerate().flat_map(|(i, input)| vec![i; input.sets().len()]);
        Self {
            firing: sets.firing(),
            bells: sets.inputs().iter().flat_map(|input| input.sets().iter().copied()).collect(),
            premises: premises.collect(),
            input_of_bell: input_of_bell.collect(),
            inputs: sets.inputs().len(),
        }
    }

    pub fn rules(&self) -> usize {
        self.premises.len() / self.inputs
    }

    /// Per rule the bells of its premises.
    pub fn premises(&self) -> impl Iterator<Item = &[usize]> {
        self.premises.chunks_exact(self.inputs)
    }

    /// Each bell with the value of its input.
    pub fn bells_at<'a>(&'a self, x: &'a [f64]) -> impl Iterator<Item = (&'a Bell, f64)> {
        self.bells.iter().zip(&self.input_of_bell).map(|(bell, &input)| (bell, x[input]))
    }

    /// Fires the rules at `x`: writes each bell's grade and each rule's normalised strength.
    ///
    /// Where all strengths underflow, far outside the universe, their logarithms are taken instead, relative to the
    /// greatest: that is the limit of the same quotient, and never 0/0.
    pub fn fire(&self, x: &[f64], grades: &mut [f64], strengths: &mut [f64]) {
        self.bells_at(x).zip(&mut *grades).for_each(|((bell, x), grade)| *grade = bell.membership(x));
        for (premises, strength) in self.premises().zip(&mut *strengths) {
            let memberships = premises.iter().map(|&bell| grades[bell]);
            *strength = match self.firing {
                Firing::Product => memberships.product(),
                Firing::Minimum => memberships.fold(1.0, f64::min),
            };
        }
        if strengths.iter().sum::<f64>() < f64::MIN_POSITIVE {
            self.fire_in_logarithms(x, grades, strengths);
        }
        let total: f64 = strengths.iter().sum();
        strengths.iter_mut().for_each(|strength| *strength /= total);
    }

    fn fire_in_logarithms(&self, x: &[f64], grades: &mut [f64], strengths: &mut [f64]) {
        self.bells_at(x).zip(&mut *grades).for_each(|((bell, x), grade)| *grade = bell.log_membership(x));
        for (premises, strength) in self.premises().zip(&mut *strengths) {
            let logarithms = premises.iter().map(|&bell| grades[bell]);
            *strength = match self.firing {
                Firing::Product => logarithms.sum(),
                Firing::Minimum => logarithms.fold(0.0, f64::min),
            };
        }
        let greatest = strengths.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        strengths.iter_mut().for_each(|strength| *strength = ComplexField::exp(*strength - greatest));
    }

    /// Fires the rules at every sample.
    pub fn fire_all(&self, data: &DataSet) -> Fired {
        let mut fired =
            Fired { grades: vec![0.0; data.len() * self.bells.len()], strengths: vec![0.0; data.len() * self.rules()] };
        let rows = fired.grades.chunks_exact_mut(self.bells.len()).zip(fired.strengths.chunks_exact_mut(self.rules()));
        for ((x, _), (grades, strengths)) in data.samples().zip(rows) {
            self.fire(x, grades, strengths);
        }
        fired
    }
}

/// A rule's output, f0 + f1 x1 + … + fn xn.
pub(crate) fn consequent(coefficients: &[f64], x: &[f64]) -> f64 {
    match coefficients.split_first() {
        Some((constant, linear)) => linear.iter().zip(x).fold(*constant, |sum, (f, x)| sum + f * x),
        None => 0.0,
    }
}

/// Layers 4 and 5: the rules' outputs weighted with their normalised strengths.
pub(crate) fn weighted_output(strengths: &[f64], consequents: &[f64], x: &[f64]) -> f64 {
    let outputs = consequents.chunks_exact(x.len() + 1).map(|coefficients| consequent(coefficients, x));
    strengths.iter().zip(outputs).map(|(strength, output)| strength * output).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::{InputSets, Universe};

    fn network(firing: Firing) -> Network {
        let universe = Universe::new(0.0, 1.0).unwrap();
        let input = |name| InputSets::grid(name, "", universe, 2).unwrap();
        Network::new(&PremiseSets::new(firing, vec![input("x"), input("y")]).unwrap())
    }

    fn strengths(network: &Network, x: &[f64]) -> Vec<f64> {
        let (mut grades, mut strengths) = (vec![0.0; network.bells.len()], vec![0.0; network.rules()]);
        network.fire(x, &mut grades, &mut strengths);
        strengths
    }

    #[test]
    fn strengths_by_hand() {
        // At (0, 1/2): memberships 1, 1/17 of x and 1/2, 1/2 of y.
        let total = 2.0 * (0.5 + 0.5 / 17.0);
        let expected = [0.5, 0.5, 0.5 / 17.0, 0.5 / 17.0].map(|w| w / total);
        approx::assert_relative_eq!(strengths(&network(Firing::Product), &[0.0, 0.5])[..], expected[..]);
        let total = 2.0 * (0.5 + 1.0 / 17.0);
        let expected = [0.5, 0.5, 1.0 / 17.0, 1.0 / 17.0].map(|w| w / total);
        approx::assert_relative_eq!(strengths(&network(Firing::Minimum), &[0.0, 0.5])[..], expected[..]);
    }

    #[test]
    fn far_outside_the_strengths_reach_the_limit_of_their_quotient() {
        // All memberships underflow at 1e90 (beyond what data sets admit); their quotients tend to 1.
        for firing in [Firing::Product, Firing::Minimum] {
            for strength in strengths(&network(firing), &[1e90, 1e90]) {
                approx::assert_relative_eq!(strength, 0.25, max_relative = 1e-10);
            }
        }
    }
}

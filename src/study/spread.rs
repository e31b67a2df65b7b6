//! Plants around a plant.

use std::str::FromStr;

use uarm_sim::{UarmImperfections, UarmParameterError, UarmPlantParameters};

use super::random::Stream;

/// How far a parameter may be from its centre, as a share of it: from 0 to below 1, so that no inertia vanishes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spread(f64);

impl Spread {
    /// A spread; `None` outside 0 ≤ share < 1.
    pub fn new(share: f64) -> Option<Self> {
        (0.0..1.0).contains(&share).then_some(Self(share))
    }

    /// The share.
    pub const fn share(self) -> f64 {
        self.0
    }

    /// Imperfections with every number of `centre` times a factor of its own, uniform in 1 ± spread: viscous and Coulomb
    /// friction of each joint, inertia scales, gain and both components of the tilt.
    ///
    /// # Errors
    /// [`UarmParameterError`] if a number overflows.
    pub fn draw(
        self,
        centre: &UarmPlantParameters,
        stream: &mut Stream,
    ) -> Result<UarmPlantParameters, UarmParameterError> {
        let mut around = |value: f64| value * stream.uniform(1.0 - self.0, 1.0 + self.0);
        UarmPlantParameters::new(UarmImperfections {
            viscous_friction: centre.viscous_friction().map(&mut around).into(),
            coulomb_friction: centre.coulomb_friction().map(&mut around).into(),
            base_inertia_scale: around(centre.base_inertia_scale()),
            link_inertia_scale: around(centre.link_inertia_scale()),
            gain: around(centre.gain()),
            tilt: centre.tilt().map(&mut around).into(),
        })
    }
}

impl FromStr for Spread {
    type Err = String;

    /// Reads `20%` or `0.2`.
    fn from_str(text: &str) -> Result<Self, String> {
        let share = match text.strip_suffix('%') {
            Some(percent) => percent.trim_end().parse::<f64>().map(|percent| percent / 100.0),
            None => text.parse(),
        };
        let share = share.ok().and_then(Self::new);
        share.ok_or_else(|| format!("found {text:?}, expected a share from 0% to below 100%, such as 20% or 0.2"))
    }
}

#[cfg(test)]
mod tests {
    use super::super::random::Subject;
    use super::*;

    fn numbers(plant: &UarmPlantParameters) -> Vec<f64> {
        let scales = [plant.base_inertia_scale(), plant.link_inertia_scale(), plant.gain()];
        let joints = plant.viscous_friction().iter().chain(plant.coulomb_friction().iter());
        joints.chain(&scales).chain(plant.tilt().iter()).copied().collect()
    }

    #[test]
    fn shares_are_read_and_wrong_ones_refused() {
        assert_eq!("20%".parse(), Ok(Spread(0.2)));
        assert_eq!("0.2".parse(), Ok(Spread(0.2)));
        assert_eq!("0%".parse(), Ok(Spread(0.0)));
        for wrong in ["", "%", "20", "100%", "-1%", "NaN", "many"] {
            assert!(wrong.parse::<Spread>().unwrap_err().contains("expected"), "{wrong}");
        }
    }

    #[test]
    fn every_number_varies_on_its_own_and_within_the_spread() {
        let centre = numbers(&UarmPlantParameters::fitted());
        let mut extremes = vec![(f64::INFINITY, f64::NEG_INFINITY); centre.len()];
        for index in 0..2_000 {
            let mut stream = Stream::new(5, Subject::Plant, index);
            let drawn = numbers(&Spread(0.2).draw(&UarmPlantParameters::fitted(), &mut stream).unwrap());
            let factors: Vec<_> = drawn.iter().zip(&centre).map(|(drawn, centre)| drawn / centre).collect();
            assert!(factors.windows(2).all(|pair| pair[0] != pair[1]));
            for (factor, (least, most)) in factors.iter().zip(&mut extremes) {
                (*least, *most) = (least.min(*factor), most.max(*factor));
            }
        }
        for (least, most) in extremes {
            assert!((0.8 - 1e-12..0.802).contains(&least), "{least}");
            assert!((1.198..1.2 + 1e-12).contains(&most), "{most}");
        }
    }

    #[test]
    fn no_spread_leaves_the_plant_as_it_is() {
        let centre = UarmPlantParameters::fitted();
        assert_eq!(Spread(0.0).draw(&centre, &mut Stream::new(1, Subject::Plant, 0)), Ok(centre));
    }
}

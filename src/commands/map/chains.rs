//! The files that the command writes.

use std::path::{Path, PathBuf};

use dem_model::{Joint, SpatialSpaceManipulator};
use uarm_urdf::{Base, Chain, Names, write_mjcf, write_urdf};

use crate::output_files::{Force, OutputFiles};

/// The longest arm that the command maps: one monomorphic copy of the map exists for each length.
pub const MOST_LINKS: usize = 8;

/// A space manipulator and its equivalent, to be written.
#[derive(Debug)]
pub struct Chains {
    space: Chain,
    /// None where a joint slides.
    equivalent: Option<Chain>,
}

impl Chains {
    /// Of a manipulator with these joints, whose DEM stands on the `base`.
    pub fn new<const N: usize>(
        names: &Names,
        base: Base,
        manipulator: &SpatialSpaceManipulator<f64, N>,
        joints: &[Joint<f64>; N],
    ) -> Self {
        let dem = manipulator.dynamically_equivalent();
        let mass = manipulator.spacecraft().mass;
        let of_dem = Names { robot: format!("{}_dem", names.robot), ..names.clone() };
        Self {
            space: Chain::space_manipulator(names, manipulator, joints),
            equivalent: Chain::equivalent(&of_dem, base, mass, &dem, joints),
        }
    }
}

impl Chains {
    /// Whether there is an equivalent that files can describe.
    pub fn has_equivalent(&self) -> bool {
        self.equivalent.is_some()
    }
}

/// How a chain becomes text.
type Write = fn(&Chain) -> String;

/// Where they go.
#[derive(Debug, clap::Args)]
pub struct Outputs {
    /// Write the space manipulator as URDF
    #[arg(long, value_name = "FILE")]
    urdf: Option<PathBuf>,
    /// Write its dynamically equivalent manipulator as URDF; its base turns about a passive joint, which URDF cannot say
    #[arg(long, value_name = "FILE")]
    dem_urdf: Option<PathBuf>,
    /// Write the space manipulator as MJCF, for MuJoCo
    #[arg(long, value_name = "FILE")]
    mjcf: Option<PathBuf>,
    /// Write its dynamically equivalent manipulator as MJCF
    #[arg(long, value_name = "FILE")]
    dem_mjcf: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
}

impl Outputs {
    /// Checks all, then writes all.
    ///
    /// # Errors
    /// If a file cannot be written, or a DEM has a joint that slides.
    pub fn write(&self, chains: &Chains, input: Option<&Path>) -> anyhow::Result<()> {
        let outputs = OutputFiles::new(self.force, input);
        let files = [&self.urdf, &self.dem_urdf, &self.mjcf, &self.dem_mjcf];
        outputs.check(files.into_iter().flatten().map(PathBuf::as_path))?;
        let wants_dem = self.dem_urdf.is_some() || self.dem_mjcf.is_some();
        anyhow::ensure!(
            chains.equivalent.is_some() || !wants_dem,
            "the equivalent manipulator cannot be written: a prismatic joint moves its link by a part of the coordinate, expected \
             revolute joints"
        );
        let written: [(&Option<PathBuf>, Option<&Chain>, Write); 4] = [
            (&self.urdf, Some(&chains.space), write_urdf),
            (&self.mjcf, Some(&chains.space), write_mjcf),
            (&self.dem_urdf, chains.equivalent.as_ref(), write_urdf),
            (&self.dem_mjcf, chains.equivalent.as_ref(), write_mjcf),
        ];
        for (file, chain, write) in written {
            if let (Some(file), Some(chain)) = (file, chain) {
                outputs.write(file, |output| output.write_all(write(chain).as_bytes()))?;
            }
        }
        Ok(())
    }
}

//! Maps the paper's space manipulator to its DEM, and moves both joints of the arm from rest.

use dem_model::nalgebra::Vector3;
use dem_model::{PlanarSpaceManipulator, ThreeLinkDem};

fn main() -> Result<(), dem_model::ParameterError> {
    let dem: ThreeLinkDem<f64> = PlanarSpaceManipulator::table_1().dynamically_equivalent().closed_form()?;
    println!("base    inertia {:.4} kg m^2, length {:.4} m", dem.base().inertia, dem.base().length);
    for (link, number) in dem.links().iter().zip(2..) {
        println!(
            "link {number}  mass {:.4} kg, inertia {:.4} kg m^2, length {:.4} m, centre of mass at {:.4} m",
            link.mass, link.inertia, link.length, link.centre_of_mass
        );
    }
    let (q, rest) = (Vector3::new(0.0, 0.35, 0.35), Vector3::zeros());
    let acceleration = dem.forward_dynamics(&q, &rest, &Vector3::new(0.0, 0.05, 0.02));
    println!("0.05 N m in joint 2 and 0.02 N m in joint 3 accelerate");
    println!("  the base by {:.4} rad/s^2,", acceleration.x);
    println!("  the joints by {:.4} and {:.4} rad/s^2", acceleration.y, acceleration.z);
    Ok(())
}

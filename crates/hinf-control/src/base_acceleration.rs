//! How a law has the base acceleration q̈_b that E = M_mb q̈_b + C_mb q̇_b needs (paper eq. 7).

/// How a law has the base acceleration. The formulas are those of [`nonlinear`](crate::laws::nonlinear).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
pub enum BaseAcceleration {
    /// As measured: reads the base velocity and acceleration. Keeps the bound if they are true.
    Measured,
    /// Eliminated by eqs. 20 and 21: reads the base velocity. Does not keep the bound.
    #[default]
    Eliminated,
    /// Left out, with all of E: reads nothing of the base.
    Omitted,
    /// By the reduced dynamics at zero momentum: reads nothing of the base, keeps the bound from rest.
    Reduced,
    /// By the reduced dynamics at the momentum that the base velocity tells: keeps the bound.
    ReducedMomentum,
}

impl BaseAcceleration {
    /// Every mode.
    pub const ALL: [Self; 5] = [Self::Measured, Self::Eliminated, Self::Omitted, Self::Reduced, Self::ReducedMomentum];

    /// The name in files and on command lines.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Measured => "measured",
            Self::Eliminated => "eliminated",
            Self::Omitted => "omitted",
            Self::Reduced => "reduced",
            Self::ReducedMomentum => "reduced-momentum",
        }
    }

    /// The mode of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|mode| mode.name() == name)
    }
}

/// How controller 2 has the base acceleration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
pub enum AdaptiveBaseAcceleration {
    /// As measured: reads the base velocity and acceleration.
    Measured,
    /// Eliminated by eqs. 20 and 21: reads the base velocity. Where an estimated matrix is not positive definite, falls back
    /// to `Omitted` for the cycle.
    #[default]
    Eliminated,
    /// Left out, with all of E: reads nothing of the base.
    Omitted,
}

impl TryFrom<BaseAcceleration> for AdaptiveBaseAcceleration {
    type Error = UnsupportedBaseAcceleration;

    fn try_from(mode: BaseAcceleration) -> Result<Self, UnsupportedBaseAcceleration> {
        match mode {
            BaseAcceleration::Measured => Ok(Self::Measured),
            BaseAcceleration::Eliminated => Ok(Self::Eliminated),
            BaseAcceleration::Omitted => Ok(Self::Omitted),
            found @ (BaseAcceleration::Reduced | BaseAcceleration::ReducedMomentum) => {
                Err(UnsupportedBaseAcceleration {
                    found,
                    expected: "measured, eliminated or omitted: the reduced inertia is not linear in the adapted parameters",
                })
            }
        }
    }
}

/// A law does not offer the mode asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the base acceleration cannot be {}, expected {expected}", .found.name())]
pub struct UnsupportedBaseAcceleration {
    /// The mode asked for.
    pub found: BaseAcceleration,
    /// What the law offers.
    pub expected: &'static str,
}

//! Choices that people make by name: on a command line, in a log. One name and one description each, in one place.

use hinf_control::{AdaptationGuard, BaseAcceleration, Disturbance, Law};
use uarm_io::realtime::RealtimePolicy;

/// A choice with a name.
pub trait Choice: Copy + PartialEq + Send + Sync + 'static {
    /// Every value, in the order in which help texts list them.
    const ALL: &'static [Self];

    /// The name, in kebab case.
    fn name(self) -> &'static str;

    /// What the value means, in a line without a full stop.
    fn description(self) -> &'static str;

    /// The value of that name.
    fn from_name(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|choice| choice.name() == name)
    }
}

/// Implements [`Choice`] for an enum from one row a value.
#[macro_export]
macro_rules! choice {
    ($type:ty: $($value:ident = $name:literal, $description:literal;)+) => {
        impl $crate::choice::Choice for $type {
            const ALL: &'static [Self] = &[$(<$type>::$value),+];

            fn name(self) -> &'static str {
                match self {
                    $(<$type>::$value => $name),+
                }
            }

            fn description(self) -> &'static str {
                match self {
                    $(<$type>::$value => $description),+
                }
            }
        }
    };
}

impl Choice for Law {
    const ALL: &'static [Self] = &Self::ALL;

    fn name(self) -> &'static str {
        Self::name(self)
    }

    fn description(self) -> &'static str {
        Self::description(self)
    }
}

choice! {
    Disturbance:
    Paper = "paper", "The paper's eq. 48, from 1 s on";
    None = "none", "No disturbance";
}

choice! {
    AdaptationGuard:
    None = "none", "As printed in the paper: nothing";
    Bounded = "bounded", "Adapted parameters are kept in a box and stand still while the torque is limited";
}

choice! {
    BaseAcceleration:
    Measured = "measured", "The differentiated base velocity: a loop of its own, stable with a filter only";
    Eliminated = "eliminated", "Eliminated with the model (eqs. 20, 21)";
    Omitted = "omitted", "Left out";
    Reduced = "reduced", "Reduced dynamics, from rest and without a torque on the base";
    ReducedMomentum = "reduced-momentum", "Reduced dynamics with the measured momentum";
}

choice! {
    RealtimePolicy:
    Enforce = "enforce", "All of it, or the run does not begin";
    Prefer = "prefer", "As much as the machine gives; the report says what";
    Off = "off", "None of it";
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_lead_back_to_their_values() {
        for policy in RealtimePolicy::ALL {
            assert_eq!(RealtimePolicy::from_name(policy.name()), Some(*policy));
        }
        assert_eq!(Law::from_name("fuzzy-model"), Some(Law::FuzzyModel));
        assert_eq!(<Disturbance as Choice>::from_name("eq48"), None);
    }
}

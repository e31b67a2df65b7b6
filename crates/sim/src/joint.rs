//! Which joint of a robot.

/// One of the `J` joints of a robot, and the drive on it.
///
/// ```
/// use uarm_sim::Joint;
/// assert_eq!(Joint::<7>::new(6).map(Joint::index), Some(6));
/// assert_eq!(Joint::<7>::new(7), None);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Joint<const J: usize = 3>(usize);

impl Joint {
    /// The base of the paper's robot, passive.
    pub const ONE: Self = Self(0);
    /// Its first driven joint.
    pub const TWO: Self = Self(1);
    /// Its second driven joint.
    pub const THREE: Self = Self(2);
}

impl<const J: usize> Joint<J> {
    /// All joints, from the base outwards.
    #[allow(clippy::indexing_slicing)] // Below J.
    pub const ALL: [Self; J] = {
        let (mut all, mut index) = ([Self(0); J], 0);
        while index < J {
            all[index] = Self(index);
            index += 1;
        }
        all
    };

    /// The joint at `index`, counted from 0 and from the base outwards; `None` from `J` on.
    pub const fn new(index: usize) -> Option<Self> {
        if index < J { Some(Self(index)) } else { None }
    }

    /// Counted from 0, below `J`.
    pub const fn index(self) -> usize {
        self.0
    }

    /// Its value among those of all joints.
    #[allow(clippy::indexing_slicing)] // Below J by construction.
    pub const fn of<T>(self, all: &[T; J]) -> &T {
        &all[self.0]
    }

    /// The same, to be changed.
    #[allow(clippy::indexing_slicing)] // Below J by construction.
    pub const fn of_mut<T>(self, all: &mut [T; J]) -> &mut T {
        &mut all[self.0]
    }
}

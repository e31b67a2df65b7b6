//! How the masses of a chain of links enter the DEM map (eq. 1), in the plane and in space alike.

use crate::Scalar;

/// What eq. 1 makes of the masses for one link i ≥ 2, with M_t the total mass and S_i = Σ_{k≤i} m'_k.
pub(crate) struct LinkMasses<T> {
    /// The DEM link's mass M_t² m'_i / (S_{i−1} S_i), in kg.
    pub(crate) dem_mass: T,
    /// S_{i−1} / M_t: the share of the mass that lies inboard of joint i. It scales L_i.
    pub(crate) inboard_share: T,
    /// S_i / M_t: the share that lies inboard of joint i+1. It scales R_i.
    pub(crate) share_with_link: T,
}

/// A walk along the chain from the spacecraft outwards.
pub(crate) struct MassChain<T> {
    total: T,
    inboard: T,
}

impl<T: Scalar> MassChain<T> {
    /// Starts at the spacecraft; masses in kg.
    pub(crate) fn new(spacecraft_mass: T, total_mass: T) -> Self {
        Self { total: total_mass, inboard: spacecraft_mass }
    }

    /// The spacecraft's own share m'_1 / M_t of the mass. It scales R_1.
    pub(crate) fn spacecraft_share(&self) -> T {
        self.inboard / self.total
    }

    /// Goes on by one link of the given mass.
    pub(crate) fn next_link(&mut self, mass: T) -> LinkMasses<T> {
        let with_link = self.inboard + mass;
        let masses = LinkMasses {
            dem_mass: (self.total / self.inboard) * (self.total / with_link) * mass,
            inboard_share: self.inboard / self.total,
            share_with_link: with_link / self.total,
        };
        self.inboard = with_link;
        masses
    }
}

//! Choosing a law at run time: names, weights, building.

use crate::law_definition::{BuildContext, BuildError, CatalogueModel};
use crate::{AnyController, Command, Controller, ControllerSettings, FrozenState, Law, LimitedJoints, Measurement};
use crate::{Reference, Synthesis, ThawError, Weights};
use dem_model::Scalar;
use nalgebra::SMatrix;

const PAPER_LAWS: usize = {
    let (mut laws, mut count) = (Law::ALL.as_slice(), 0);
    while let [law, rest @ ..] = laws {
        if law.published_indices().is_some() {
            count += 1;
        }
        laws = rest;
    }
    count
};

impl Law {
    /// The paper's laws, in its order. They stand first in [`Law::ALL`].
    pub const PAPER: [Self; PAPER_LAWS] = match Self::ALL.first_chunk() {
        Some(laws) => *laws,
        None => unreachable!(),
    };

    /// The law of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|law| law.name() == name)
    }

    /// Whether the law is one of the paper's.
    pub const fn is_in_paper(self) -> bool {
        self.published_indices().is_some()
    }
}

impl<const N: usize> ControllerSettings<N> {
    /// The H∞ weights of `law`. A law without weights of its own is given those of controller 1.
    pub fn weights<T: Scalar>(&self, law: Law) -> Weights<T, N> {
        let state = self.state_weights(law).unwrap_or_else(|| self.nonlinear.weights());
        Weights {
            velocity: state.q1.matrix(),
            position: state.q2.matrix(),
            cross: SMatrix::zeros(),
            control: self.r.matrix(),
            attenuation_level: T::constant(self.attenuation_level),
            reading: self.reading,
        }
    }

    /// `law` for `context`.
    ///
    /// ```
    /// use dem_model::ThreeLinkDem;
    /// use hinf_control::{BuildContext, ControllerSettings, Law};
    /// let settings = ControllerSettings::default();
    /// for law in Law::ALL {
    ///     settings.build(law, &BuildContext::new(ThreeLinkDem::<f64>::table_2()))?;
    /// }
    /// # Ok::<(), hinf_control::BuildError>(())
    /// ```
    ///
    /// # Errors
    /// [`BuildError`] if the weights allow no design, or a setting is refused.
    pub fn build<T: Scalar, const B: usize, M: CatalogueModel<T, N, B>>(
        &self,
        law: Law,
        context: &BuildContext<T, M>,
    ) -> Result<AnyController<T, N, B, M>, BuildError> {
        self.build_with(law, Synthesis::new(&self.weights(law))?, context)
    }
}

impl<T, const N: usize, const B: usize, M> Controller<T, N, B> for AnyController<T, N, B, M>
where
    T: Scalar,
    M: CatalogueModel<T, N, B>,
{
    fn update(&mut self, measurement: &Measurement<T, N, B>, reference: &Reference<T, N>, period: T) -> Command<T, N> {
        self.law_mut().update(measurement, reference, period)
    }

    fn limited(&mut self, joints: LimitedJoints<N>) {
        self.law_mut().limited(joints);
    }

    fn hold_adaptation(&mut self) {
        self.law_mut().hold_adaptation();
    }

    fn parameters(&self) -> &[T] {
        self.law().parameters()
    }

    fn reset(&mut self) {
        self.law_mut().reset();
    }

    fn freeze(&self) -> FrozenState<T, N> {
        self.law().freeze()
    }

    fn thaw(&mut self, state: &FrozenState<T, N>) -> Result<(), ThawError> {
        self.law_mut().thaw(state)
    }
}

//! What is made of the list of laws.

/// From lines `Variant => module,`: the modules, [`Law`](crate::Law), [`ControllerSettings`](crate::ControllerSettings) with
/// a field per law, and [`AnyController`](crate::AnyController) with a variant per law. Each module has a `Settings` that
/// implements [`LawDefinition`](crate::LawDefinition).
macro_rules! laws {
    ($($variant:ident => $module:ident,)*) => {
        $(pub mod $module;)*

        use crate::law_definition::{AdaptationSettings, BuildContext, BuildError, CatalogueModel, LawDefinition};
        use crate::law_definition::{DerivedWeights, LawVariant, PaperArm, PaperWeights, PublishedIndices, StateWeights};
        use crate::{BaseAcceleration, Controller, Firing, Synthesis, SymmetricWeight, UnsupportedBaseAcceleration};
        use crate::{PAPER_ATTENUATION_LEVEL, WeightReading};
        use dem_model::{Scalar, ThreeLinkDem};

        /// A control law of this crate.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub enum Law {
            $(
                #[doc = concat!("The law of [`laws::", stringify!($module), "`](crate::laws::", stringify!($module), ").")]
                $variant,
            )*
        }

        impl Law {
            /// Every law, in the order of the list: the paper's in its order, then the others.
            pub const ALL: [Self; [$(Self::$variant),*].len()] = [$(Self::$variant),*];

            /// The name in files and on command lines.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => <$module::Settings<2> as LawDefinition<2>>::NAME,)*
                }
            }

            /// What the law is, in a line.
            pub const fn description(self) -> &'static str {
                match self {
                    $(Self::$variant => <$module::Settings<2> as LawDefinition<2>>::DESCRIPTION,)*
                }
            }

            /// The paper's Table 4; `None` for a law that is not in the paper.
            pub const fn published_indices(self) -> Option<PublishedIndices> {
                match self {
                    $(Self::$variant => <$module::Settings<2> as LawDefinition<2>>::PUBLISHED_INDICES,)*
                }
            }

            /// Forms of the law that a comparison shows as rows of their own.
            pub const fn variants(self) -> &'static [LawVariant] {
                match self {
                    $(Self::$variant => <$module::Settings<2> as LawDefinition<2>>::VARIANTS,)*
                }
            }
        }

        /// Everything that can be chosen about the laws besides the model: what they share, and a section for each.
        ///
        /// The [`Default`] is the paper's experiment, Table 3 read as blocks, and so there is one for two joints only. For another
        /// arm take [`ControllerSettings::derived`]. A section that a file lacks is the paper's; for another number of joints it is
        /// refused.
        #[derive(Clone, Copy, Debug, PartialEq)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
        #[cfg_attr(feature = "serde", serde(try_from = "WrittenSettings<N>"))]
        pub struct ControllerSettings<const N: usize = 2> {
            /// γ, positive.
            #[cfg_attr(feature = "serde", serde(rename = "attenuation_level"))]
            pub attenuation_level: f64,
            /// What the numbers given for Q1 and Q2 of all laws are.
            pub reading: WeightReading,
            /// R, the same for all laws.
            pub r: SymmetricWeight<N>,
            $(
                #[doc = concat!("Settings of [`laws::", stringify!($module), "`](crate::laws::", stringify!($module), ").")]
                pub $module: $module::Settings<N>,
            )*
        }

        /// The same as it is written: sections may be missing.
        #[cfg(feature = "serde")]
        #[derive(serde::Deserialize)]
        #[serde(rename_all = "kebab-case")]
        struct WrittenSettings<const N: usize> {
            #[serde(rename = "attenuation_level")]
            attenuation_level: f64,
            reading: WeightReading,
            r: SymmetricWeight<N>,
            $($module: Option<$module::Settings<N>>,)*
        }

        #[cfg(feature = "serde")]
        impl<const N: usize> TryFrom<WrittenSettings<N>> for ControllerSettings<N> {
            type Error = MissingSection;

            fn try_from(written: WrittenSettings<N>) -> Result<Self, MissingSection> {
                Ok(Self {
                    attenuation_level: written.attenuation_level,
                    reading: written.reading,
                    r: written.r,
                    $($module: match written.$module {
                        Some(settings) => settings,
                        None => of_the_paper::<$module::Settings<2>, $module::Settings<N>>()
                            .ok_or(MissingSection { law: Law::$variant.name(), joints: N })?,
                    },)*
                })
            }
        }

        impl<const N: usize> Default for ControllerSettings<N>
        where
            PaperArm: PaperWeights<N>,
        {
            fn default() -> Self {
                Self {
                    attenuation_level: PAPER_ATTENUATION_LEVEL,
                    reading: WeightReading::Blocks,
                    r: PaperArm::diagonal([0.9, 2.5]),
                    $($module: <$module::Settings<N> as Default>::default(),)*
                }
            }
        }

        impl<const N: usize> ControllerSettings<N> {
            /// Settings of every law with these weights, read as blocks.
            pub(crate) fn from_derived(weights: &DerivedWeights<N>) -> Self {
                Self {
                    attenuation_level: weights.attenuation_level,
                    reading: WeightReading::Blocks,
                    r: weights.r,
                    $($module: <$module::Settings<N> as LawDefinition<N>>::derived(weights),)*
                }
            }

            /// Q1 and Q2 of `law`; `None` for a law without weights of its own.
            pub fn state_weights(&self, law: Law) -> Option<StateWeights<N>> {
                match law {
                    $(Law::$variant => LawDefinition::<N>::state_weights(&self.$module),)*
                }
            }

            /// How `law` adapts; `None` for a law that does not.
            pub fn adaptation(&self, law: Law) -> Option<AdaptationSettings> {
                match law {
                    $(Law::$variant => LawDefinition::<N>::adaptation(&self.$module),)*
                }
            }

            /// How the fuzzy rules of `law` fire; `None` for a law without.
            pub fn firing(&self, law: Law) -> Option<Firing> {
                match law {
                    $(Law::$variant => LawDefinition::<N>::firing(&self.$module),)*
                }
            }

            /// Chooses how `law` has the base acceleration.
            ///
            /// # Errors
            /// [`UnsupportedBaseAcceleration`] if the law does not offer the mode.
            pub fn set_base_acceleration(
                &mut self,
                law: Law,
                mode: BaseAcceleration,
            ) -> Result<(), UnsupportedBaseAcceleration> {
                match law {
                    $(Law::$variant => LawDefinition::<N>::set_base_acceleration(&mut self.$module, mode),)*
                }
            }

            /// `law` with an H∞ design that is already solved.
            pub(crate) fn build_with<T: Scalar, const B: usize, M: CatalogueModel<T, N, B>>(
                &self,
                law: Law,
                synthesis: Synthesis<T, N>,
                context: &BuildContext<T, M>,
            ) -> Result<AnyController<T, N, B, M>, BuildError> {
                match law {
                    $(Law::$variant => self.$module.build(synthesis, context).map(AnyController::$variant),)*
                }
            }
        }

        /// Any law of [`Law`], chosen at run time: see [`ControllerSettings::build`].
        #[derive(Clone, Debug, PartialEq)]
        #[allow(clippy::large_enum_variant)] // Boxing would allocate; the largest is about 3 KiB for two joints.
        pub enum AnyController<
            T: Scalar,
            const N: usize = 2,
            const B: usize = 1,
            M: CatalogueModel<T, N, B> = ThreeLinkDem<T>,
        > {
            $(
                #[doc = concat!("The law of [`laws::", stringify!($module), "`](crate::laws::", stringify!($module), ").")]
                $variant(<$module::Settings<N> as LawDefinition<N>>::Controller<T, B, M>),
            )*
        }

        impl<T: Scalar, const N: usize, const B: usize, M: CatalogueModel<T, N, B>> AnyController<T, N, B, M> {
            pub(crate) fn law(&self) -> &dyn Controller<T, N, B> {
                match self {
                    $(Self::$variant(law) => law,)*
                }
            }

            pub(crate) fn law_mut(&mut self) -> &mut dyn Controller<T, N, B> {
                match self {
                    $(Self::$variant(law) => law,)*
                }
            }
        }
    };
}
pub(super) use laws;

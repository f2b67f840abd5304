/// The functions of an application that measures nothing: all, or all but `sample`.
macro_rules! idle {
    () => {
        fn sample(&mut self, _: Instant, _: &Reading) -> Self::Values {
            Self::Values::INITIAL
        }

        idle!(except sample);
    };
    (except sample) => {
        fn start(&mut self, _: Calibration) {}

        fn apply(&mut self, _: Instant, _: &Parameters<Self::Table>) -> Self::Values {
            Self::Values::INITIAL
        }

        fn stale(&mut self) -> Self::Values {
            Self::Values::INITIAL
        }
    };
}

//! The macro that derives the form that the device uses from the tables of a product.

/// Derives the form that the device uses from a table, and checks the table. A mistake in it is a compile error at this macro, also of
/// `cargo check`. Its message begins with the line of the row and names the row: `src/tables.rs:42: object 2110h:01: ...`. A function of
/// your own that returns a row is `#[track_caller]`, so that this is the line in the table. Use the macro in the `impl` of a trait for a
/// type without generic parameters:
///
/// | macro                   | in an `impl` of                                  | derives                                     |
/// |-------------------------|--------------------------------------------------|---------------------------------------------|
/// | `project!(parameters)`  | [`param::Table`](crate::param::Table)            | the rows, the factory values and the ranges |
/// | `project!(objects)`     | [`canopen::Product`](crate::canopen::Product)    | the rows of the object dictionary           |
/// | `project!(functions)`   | [`fsc::Product`](crate::fsc::Product)            | the function select codes                   |
/// | `project!(attributes)`  | [`devicenet::Product`](crate::devicenet::Product)| the objects of the vendor and the assemblies|
/// | `project!(groups)`      | [`j1939::Product`](crate::j1939::Product)        | the trouble codes, the proof of the checks  |
///
/// ```
/// use plumbline::param::{DataType, Parameter, ParameterId, Table};
///
/// struct Gauge;
///
/// impl Table for Gauge {
///     const PARAMETERS: &'static [Parameter] =
///         &[Parameter::new(ParameterId(0), "Period", DataType::U16).within(1, 1000, 250)];
///     plumbline::project!(parameters);
/// }
/// ```
///
/// The same with a factory value that is not permitted does not compile:
///
/// ```compile_fail
/// use plumbline::param::{DataType, Parameter, ParameterId, Table};
///
/// struct Gauge;
///
/// impl Table for Gauge {
///     const PARAMETERS: &'static [Parameter] =
///         &[Parameter::new(ParameterId(0), "Period", DataType::U16).within(1, 1000, 1250)];
///     plumbline::project!(parameters);
/// }
/// ```
// A check is in a `const` block: only such a block of an associated constant is evaluated where it is written.
#[macro_export]
macro_rules! project {
    (parameters) => {
        type Numbers = [u32; <Self as $crate::param::Table>::PARAMETERS.len()];
        const FACTORY: &'static Self::Numbers =
            const { &$crate::param::projection::factory(<Self as $crate::param::Table>::PARAMETERS) };
        const PARAMETER_ROWS: &'static [$crate::param::ParameterRow] = const {
            &$crate::param::projection::rows::<{ <Self as $crate::param::Table>::PARAMETERS.len() }>(
                <Self as $crate::param::Table>::PARAMETERS,
                <Self as $crate::param::Table>::CONSTRAINTS,
            )
        };
        const RELATIONS: &'static [$crate::param::Relation] = const {
            &$crate::param::Constraint::relations::<
                { <Self as $crate::param::Table>::CONSTRAINTS.len() },
            >(<Self as $crate::param::Table>::CONSTRAINTS)
        };
        const POOL: &'static [$crate::param::Limits] = const {
            &$crate::param::projection::pool::<
                { $crate::param::projection::pool_size(<Self as $crate::param::Table>::PARAMETERS) },
            >(<Self as $crate::param::Table>::PARAMETERS)
        };
        const STORED_SIZE: usize =
            $crate::param::projection::stored_size(<Self as $crate::param::Table>::PARAMETERS);
        type Buffer = $crate::store::Records<
            {
                $crate::store::buffer_size(
                    <Self as $crate::param::Table>::STORED_SIZE,
                    <Self as $crate::param::Table>::KEEPS_USAGE,
                )
            },
            { <Self as $crate::param::Table>::KEEPS_USAGE },
        >;
        const REALS: bool =
            $crate::param::projection::has_reals(<Self as $crate::param::Table>::PARAMETERS);
        const WIDE_LIMITS: &'static [$crate::param::WideLimits] = const {
            &$crate::param::projection::wide_limits::<
                { $crate::param::projection::wide_count(<Self as $crate::param::Table>::PARAMETERS) },
            >(<Self as $crate::param::Table>::PARAMETERS)
        };
    };
    (objects) => {
        const ROWS: &'static [$crate::canopen::row::Row] = const {
            $crate::canopen::check::check::<Self>();
            &$crate::canopen::row::rows::<{ <Self as $crate::canopen::Product>::OBJECTS.len() }>(
                <Self as $crate::canopen::Product>::OBJECTS,
                <$crate::project!(@application canopen) as $crate::param::Table>::PARAMETERS,
                $crate::project!(@quantities canopen),
            )
        };
        const TEXTS: &'static [&'static str] = const {
            &$crate::canopen::row::texts::<
                { $crate::canopen::row::text_count(<Self as $crate::canopen::Product>::OBJECTS) },
            >(<Self as $crate::canopen::Product>::OBJECTS)
        };
        const TPDO_SETTINGS: &'static [$crate::canopen::setting::TpdoSettings] = const {
            &$crate::canopen::setting::tpdo_settings::<
                { <<Self as $crate::canopen::Product>::Tpdos as $crate::canopen::Tpdos>::COUNT },
            >(<Self as $crate::canopen::Product>::OBJECTS)
        };
        const GROUP_INDICES: &'static [(u16, u16)] = const {
            &$crate::canopen::Group::indices::<
                { <Self as $crate::canopen::Product>::GROUPS.len() },
            >(<Self as $crate::canopen::Product>::GROUPS)
        };
        const LSS_RATES: &'static [$crate::canopen::LssRates] = const {
            &$crate::canopen::LssTable::rates::<
                { <Self as $crate::canopen::Product>::LSS_TABLES.len() },
            >(<Self as $crate::canopen::Product>::LSS_TABLES)
        };
    };
    (functions) => {
        const CODES: $crate::fsc::projection::Codes = $crate::fsc::projection::Codes::new(
            const {
                $crate::fsc::projection::check::<Self>();
                &$crate::fsc::projection::groups(
                    <Self as $crate::fsc::Product>::ACCESS,
                    <Self as $crate::fsc::Product>::FUNCTIONS,
                )
            },
            const {
                &$crate::fsc::projection::rows::<
                    {
                        $crate::fsc::projection::row_count(
                            <Self as $crate::fsc::Product>::ACCESS,
                            <Self as $crate::fsc::Product>::FUNCTIONS,
                        )
                    },
                >(
                    <Self as $crate::fsc::Product>::ACCESS,
                    <Self as $crate::fsc::Product>::FUNCTIONS,
                    &<Self as $crate::fsc::Product>::ROLES,
                    <$crate::project!(@application fsc) as $crate::param::Table>::CONSTRAINTS,
                )
            },
            const {
                &$crate::fsc::projection::items::<
                    {
                        $crate::fsc::projection::item_count(
                            <Self as $crate::fsc::Product>::ACCESS,
                            <Self as $crate::fsc::Product>::FUNCTIONS,
                        )
                    },
                >(
                    <Self as $crate::fsc::Product>::ACCESS,
                    <Self as $crate::fsc::Product>::FUNCTIONS,
                    <$crate::project!(@application fsc) as $crate::param::Table>::PARAMETERS,
                    $crate::project!(@quantities fsc),
                )
            },
        );
    };
    (attributes) => {
        const OBJECT_ROWS: &'static [$crate::devicenet::projection::ObjectRow] = const {
            $crate::devicenet::consistency::check::<Self>();
            &$crate::devicenet::projection::objects::<
                { <Self as $crate::devicenet::Product>::OBJECTS.len() },
            >(<Self as $crate::devicenet::Product>::OBJECTS)
        };
        const ATTRIBUTE_ROWS: &'static [$crate::devicenet::projection::AttributeRow] = const {
            &$crate::devicenet::projection::attributes::<
                {
                    $crate::devicenet::projection::attribute_count(
                        <Self as $crate::devicenet::Product>::OBJECTS,
                    )
                },
            >(
                <Self as $crate::devicenet::Product>::OBJECTS,
                <$crate::project!(@application devicenet) as $crate::param::Table>::PARAMETERS,
                $crate::project!(@quantities devicenet),
            )
        };
        const CONSTANTS: &'static [u32] = const {
            &$crate::devicenet::projection::constants::<
                {
                    $crate::devicenet::projection::constant_count(
                        <Self as $crate::devicenet::Product>::OBJECTS,
                    )
                },
            >(<Self as $crate::devicenet::Product>::OBJECTS)
        };
        const ASSEMBLY_ROWS: &'static [$crate::devicenet::projection::AssemblyRow] = const {
            &$crate::devicenet::projection::assemblies::<
                { <Self as $crate::devicenet::Product>::ASSEMBLIES.len() },
            >(<Self as $crate::devicenet::Product>::ASSEMBLIES)
        };
    };
    (groups) => {
        const CHECKED: $crate::j1939::Checked = const { $crate::j1939::Checked::tables::<Self>() };
        const TROUBLE_CODES: &'static [$crate::j1939::diagnostics::Code] = const {
            &$crate::j1939::diagnostics::Trouble::codes::<
                { <Self as $crate::j1939::Product>::TROUBLES.len() },
            >(<Self as $crate::j1939::Product>::TROUBLES)
        };
    };
    (@application $protocol:ident) => {
        <<Self as $crate::$protocol::Product>::Application as $crate::application::Application>::Table
    };
    (@quantities $protocol:ident) => {
        <<Self as $crate::$protocol::Product>::Application as $crate::application::Application>::QUANTITIES
    };
}

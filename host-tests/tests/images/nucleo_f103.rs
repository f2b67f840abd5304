//! The tests that also run with the images for the Nucleo-F103RB: what its board changes. These are the pins of accelerometer, LEDs and
//! supply, SPI2, the clock from the ST-LINK, and the place of the parameters.

use host_tests::effort;
use plumbline::model::catalog;
use stm32_sim::board::Board;
use stm32_sim::firmware;

also! {
    crate::rig::on_the_nucleo_f103;
    accelerometer:
        accelerometer_failure_is_reported_within_200_ms_and_cleared_after_recovery;
    accelerometer_faults:
        fault_is_reported_and_ends_within_its_times,
        spi_runs_at_2_mhz_with_slow_edges;
    adxl355:
        first_frame_comes_within_100_ms_with_a_right_angle,
        failure_is_reported_and_cleared_after_recovery,
        disturbed_register_is_restored_without_a_wrong_angle,
        self_test_reports_the_working_axes;
    boot:
        first_frame_is_sent_with_first_reading,
        cause_of_the_last_reset_is_kept,
        sensor_starts_after_a_reset_by_its_pin_at_any_time,
        module_leds_are_outputs_and_off;
    clock:
        bus_is_recessive_and_heater_off_before_the_reset,
        sensor_without_a_crystal_shows_the_error_led_and_stays_off_the_bus,
        crystal_that_starts_after_a_second_is_used;
    disturbed:
        bits_disturbed_in_the_boot_are_restored,
        disturbed_bits_of_a_can_controller_that_joins_the_bus_are_restored,
        disturbed_bits_of_the_can_controller_are_restored,
        disturbed_pll_in_the_boot_restarts_the_sensor,
        disturbed_bits_of_clocks_pins_and_timers_are_restored,
        disturbed_bits_of_the_processor_are_restored,
        accelerometer_measures_again_after_each_disturbed_bit_of_its_spi,
        disturbed_bits_of_the_converter_are_restored,
        disturbed_bits_of_the_detection_are_restored;
    errors:
        run_led_flickers_during_detection_and_is_on_afterwards;
    faults:
        stack_overflow_restarts_the_sensor_without_overwriting_static_variables;
    ims360:
        image_measures_supply_and_angular_rate;
    jn2101:
        terminating_resistor_is_switched_and_is_off_without_power,
        heating_power_depends_on_the_temperature;
    memory:
        saves_work_across_page_changes_with_any_times_of_the_flash,
        broken_flash_sets_cmd_param_error_and_eeprom_error;
    memory_sizes:
        too_small_ram_is_shown_by_run_and_error_led,
        too_small_flash_is_shown_by_run_and_error_led;
    probe:
        probe_reads_log_and_programs_sleeping_sensor_twice;
    sensing:
        supply_is_measured_within_13_mv;
    timing:
        sync_is_answered_within_15_us;
}

/// The build checks each image. On this board there is room for the log of each product; one of each family without `PLUMBLINE_LONG`.
#[test]
#[ignore = "another board or other silicon: `.ci/long ignored`"]
fn images_with_the_log_of_all_products_have_no_unsafe_instruction() {
    let all: Vec<&str> = catalog::bases().map(|product| product.name).collect();
    let names = effort::choose(vec!["is2", "jn2101", "ims360", "tiltix080"], all);
    let built = firmware::build_with_log(Board::NucleoF103, &names)
        .unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(built.len(), names.len());
}

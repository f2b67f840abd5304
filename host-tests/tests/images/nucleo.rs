//! The tests that also run with the images for the Nucleo: what its board or its chip changes. These are pins and LEDs, clock tree,
//! watchdog, debug registers, flash, supply monitor, ADC, reset causes, vector table, filters that two controllers share, and the
//! timing of the Cortex-M4.

use crate::rig::on;
use stm32_sim::chip::Chip;

macro_rules! also_on_the_nucleo {
    ($($module:ident: $($test:ident),+;)+) => {
        $(mod $module {
            $(#[test]
            fn $test() {
                super::on(super::Chip::F446, crate::$module::$test);
            })+
        })+
    };
}

also_on_the_nucleo! {
    accelerometer:
        accelerometer_failure_is_reported_within_200_ms_and_cleared_after_recovery,
        i2c_of_the_accelerometer_is_disabled;
    boot:
        first_frame_is_sent_with_first_reading,
        reset_command_switches_the_heater_off,
        ram_is_kept_in_a_reset_and_lost_without_power,
        watchdog_restarts_a_main_loop_that_hangs,
        cause_of_the_last_reset_is_kept,
        heater_is_off_while_a_debugger_halts_the_processor,
        watchdog_does_not_reset_a_working_sensor,
        module_leds_are_outputs_and_off;
    can_faults:
        reset_of_controller_can_take_any_time,
        transmit_output_that_locks_in_silent_mode_never_reaches_the_bus,
        filters_do_not_depend_on_can2sb;
    clock:
        bus_is_recessive_after_crystal_stops_in_a_frame,
        sensor_restarts_when_stopped_crystal_oscillates_again,
        heater_is_off_after_crystal_stops,
        bus_is_recessive_and_heater_off_before_the_reset,
        sensor_without_a_crystal_shows_the_error_led_and_stays_off_the_bus,
        crystal_that_starts_after_a_second_is_used;
    detection:
        each_of_the_ten_rates_is_detected_without_disturbing_the_bus;
    errors:
        run_led_flickers_during_detection_and_is_on_afterwards,
        sensor_without_recovery_stays_bus_off_until_a_restart;
    faults:
        no_image_has_a_panic_path,
        undefined_instruction_restarts_the_sensor,
        unexpected_interrupt_restarts_the_sensor,
        stack_overflow_restarts_the_sensor_without_overwriting_static_variables;
    fusion:
        swing_is_followed_within_5_ms_and_0_3_deg;
    halves:
        requests_on_an_occupied_bus_are_answered_in_order_without_a_pause;
    ims360:
        image_measures_supply_and_angular_rate;
    ims360_faults:
        angle_is_right_after_a_rotation_in_a_save_that_erases;
    jn2101:
        supply_below_its_limit_is_reported,
        terminating_resistor_is_switched_and_is_off_without_power,
        heating_power_depends_on_the_temperature;
    memory:
        power_cut_at_any_half_word_keeps_the_old_or_the_new_parameters,
        power_cut_in_a_save_that_erases_keeps_the_old_or_the_new_parameters,
        saves_work_across_page_changes_with_any_times_of_the_flash,
        broken_flash_sets_cmd_param_error_and_eeprom_error,
        erase_of_a_page_loses_only_frames_beyond_the_fifo;
    sensing:
        supply_is_measured_within_13_mv;
    supply:
        save_at_a_low_supply_is_refused_and_changes_nothing,
        save_ends_before_the_supply_is_too_low,
        sensor_starts_when_the_supply_is_high_enough_to_erase;
    tiltix_network:
        leds_show_the_self_test_and_the_connections;
    timing:
        sync_is_answered_within_15_us,
        cyclic_mode_keeps_its_period;
    unit:
        image_has_the_identity_in_its_flash;
}

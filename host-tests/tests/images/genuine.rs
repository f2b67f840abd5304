//! The tests that also run on a microcontroller of ST, because its silicon behaves differently from the worst silicon.

also! {
    crate::rig::on_genuine_silicon;
    boot:
        first_frame_is_sent_with_first_reading;
    can_faults:
        transmit_output_that_locks_in_silent_mode_never_reaches_the_bus;
    jn2101:
        sync_is_answered_with_both_tpdos;
    memory:
        saves_work_across_page_changes_with_any_times_of_the_flash;
    probe:
        probe_reads_log_and_programs_sleeping_sensor_twice;
    timing:
        sync_is_answered_within_15_us;
    traces:
        image_of_the_is2_passes_its_traces;
}

/// On the Nucleo-F103RB, whose microcontroller is one of ST.
mod nucleo_f103 {
    also! {
        crate::rig::on_the_genuine_nucleo_f103;
        boot:
            first_frame_is_sent_with_first_reading;
        can_faults:
            transmit_output_that_locks_in_silent_mode_never_reaches_the_bus;
        jn2101:
            sync_is_answered_with_both_tpdos;
        memory:
            saves_work_across_page_changes_with_any_times_of_the_flash;
        probe:
            probe_reads_log_and_programs_sleeping_sensor_twice;
    }
}

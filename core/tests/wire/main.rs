//! Tests of the products at the CAN frame level: received and sent frames with their times, compared with the manuals.

mod canopen_cob_ids;
mod canopen_codings;
mod canopen_configuration;
mod canopen_dictionary;
mod canopen_emergencies;
mod canopen_jn2101;
mod canopen_mapping;
mod canopen_memory;
mod canopen_network;
mod canopen_node_id;
mod canopen_pdo;
mod canopen_saves;
mod canopen_sdo;
mod canopen_sizes;
mod canopen_triggers;
mod fsc_behaviour;
mod fsc_codings;
mod fsc_heating;
mod fsc_memory;
mod fsc_requests;
mod halves;
mod one_application;
mod starting;
mod tester;

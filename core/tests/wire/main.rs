//! Tests of the products at the CAN frame level: received and sent frames with their times, compared with the manuals.

mod canopen;
mod composed;
mod devicenet;
mod diagnosis;
mod driver;
mod fsc;
mod j1939;
mod one_application;
mod starting;
mod stranger;
mod tester;
mod unit;
mod updating;

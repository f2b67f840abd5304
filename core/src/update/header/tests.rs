//! Tests of the header and of its checks.

use super::*;

const DEVICE: Device = Device {
    product: Some(3),
    board: 1,
    layout: 1,
};

/// The first page of an image of 4 KiB for the device, with its header.
fn page() -> ([u8; PAGE], Header) {
    let contents = Contents {
        product: 3,
        element: Element::Ism330dhcx,
        board: 1,
        layout: 1,
        key: 0,
        version: 0x0001_0203,
        hash: [0; 32],
    };
    let body: [u8; 4096] = core::array::from_fn(|place| place as u8);
    let header = Header::new(&contents, &body).unwrap();
    let mut page = *body.first_chunk().unwrap();
    page[PLACE..PLACE + SIZE].copy_from_slice(header.bytes());
    (page, header)
}

#[test]
fn crc_is_that_of_the_unit_of_an_stm32() {
    // The check value of CRC-32/MPEG-2 is that of the bytes "123456789"; the unit takes words, so "12345678" without the last byte.
    let reference = Crc::<u32>::new(&CRC_32_MPEG_2).checksum(b"12345678");
    assert_eq!(crc(&[b"4321", b"8765"]), reference);
    // RM0008, chapter 4: the unit starts at FFFF FFFFh.
    assert_eq!(crc(&[]), 0xFFFF_FFFF);
}

#[test]
fn header_is_read_as_it_was_written() {
    let (_, header) = page();
    assert_eq!(Header::parse(header.bytes()), Some(header));
    assert_eq!(
        (header.product(), header.element()),
        (3, Element::Ism330dhcx)
    );
}

#[test]
fn header_has_the_layout_of_its_document() {
    let (_, header) = page();
    let bytes = header.bytes();
    assert_eq!(bytes[..6], *b"PLUM\x01\x01");
    assert_eq!(bytes[6..12], [3, 0, 1, 0, 0, 0]);
    assert_eq!(bytes[12..20], [3, 2, 1, 0, 0, 16, 0, 0]);
    assert_eq!(bytes[60..], [0xFF; 4]);
}

#[test]
fn image_for_the_device_is_accepted() {
    let (page, header) = page();
    assert_eq!(
        header.check(crc(&first_page_parts(&page)), &DEVICE, 4096, None),
        Ok(())
    );
    assert_eq!(
        header.check(
            crc(&first_page_parts(&page)),
            &DEVICE,
            4096,
            Some(0x0001_0203)
        ),
        Ok(())
    );
    let any = Device {
        product: None,
        ..DEVICE
    };
    assert_eq!(
        header.check(crc(&first_page_parts(&page)), &any, 4096, None),
        Ok(())
    );
}

#[test]
fn each_wrong_bit_of_the_first_page_is_refused() {
    let (page, _) = page();
    // The last four bytes of the header are the commit and unused.
    for place in (0..PAGE).filter(|place| !(PLACE + 60..PLACE + SIZE).contains(place)) {
        for bit in 0..8 {
            let mut wrong = page;
            wrong[place] ^= 1 << bit;
            let bytes = wrong[PLACE..].first_chunk().unwrap();
            let header = Header::parse(bytes);
            let result = header
                .map(|header| header.check(crc(&first_page_parts(&wrong)), &DEVICE, 1 << 30, None));
            assert_ne!(result, Some(Ok(())), "byte {place}, bit {bit}");
        }
    }
}

#[test]
fn image_for_another_device_is_refused_with_its_reason() {
    let (page, header) = page();
    let check =
        |device, size, present| header.check(crc(&first_page_parts(&page)), &device, size, present);
    let product = Some(4);
    let cases = [
        (
            check(Device { product, ..DEVICE }, 4096, None),
            Failure::Product,
        ),
        (
            check(
                Device {
                    product: Some(Element::Adxl355.with(3)),
                    ..DEVICE
                },
                4096,
                None,
            ),
            Failure::Product,
        ),
        (
            check(Device { board: 2, ..DEVICE }, 4096, None),
            Failure::Board,
        ),
        (
            check(
                Device {
                    layout: 2,
                    ..DEVICE
                },
                4096,
                None,
            ),
            Failure::Board,
        ),
        (check(DEVICE, 4095, None), Failure::Size),
        (check(DEVICE, 4096, Some(0x0001_0204)), Failure::Older),
    ];
    for (result, reason) in cases {
        assert_eq!(result, Err(reason));
    }
}

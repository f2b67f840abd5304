//! The sequences of instructions whose cycles are measured.

/// A sequence of instructions as a function.
#[repr(C)]
pub struct Sequence {
    name: *const u8,
    length: usize,
    /// Arguments: CYCCNT, a word in RAM, a register of a peripheral, a number. Returns the difference of CYCCNT.
    pub code: unsafe extern "C" fn(*mut u32, *mut u32, *mut u32, u32) -> u32,
    /// The register of the third argument.
    pub register: Register,
}

/// The peripheral that a sequence accesses.
#[derive(Clone, Copy)]
#[repr(C)]
pub enum Register {
    /// On APB1, at half the clock.
    Apb1,
    /// On APB2, at the full clock.
    Apb2,
    /// On the AHB, without a bridge.
    Ahb,
}

// SAFETY: the name is constant.
unsafe impl Sync for Sequence {}

impl Sequence {
    #[cfg(feature = "defmt")]
    pub fn name(&self) -> &'static str {
        // SAFETY: `sequences!` has split a string into address and length.
        unsafe { str::from_utf8_unchecked(core::slice::from_raw_parts(self.name, self.length)) }
    }
}

/// Declares sequences. Each is a function that reads CYCCNT before and after it, from a line of the flash on. R0 to R3, R5 and R12
/// are free: R1 points to RAM, R2 to the register, R3 is the number, R5 = 0.
macro_rules! sequences {
    ($($register:ident $name:literal $symbol:ident: $code:literal;)*) => {
        $(core::arch::global_asm!(
            concat!(".section .text.", stringify!($symbol), ",\"ax\",%progbits"),
            ".balign 16",
            concat!(".global ", stringify!($symbol)),
            concat!(".type ", stringify!($symbol), ",%function"),
            ".thumb_func",
            concat!(stringify!($symbol), ":"),
            "push {{r4, r5, r6, r7, lr}}",
            "mov r4, r0",
            "movs r5, #0",
            "dsb sy",
            "isb sy",
            ".balign 16",
            "ldr r6, [r4]",
            $code,
            "ldr r7, [r4]",
            "subs r0, r7, r6",
            "pop {{r4, r5, r6, r7, pc}}",
            ".balign 4",
            ".ltorg",
            concat!(".size ", stringify!($symbol), ", . - ", stringify!($symbol)),
            ".text",
        );)*

        unsafe extern "C" {
            $(fn $symbol(cyccnt: *mut u32, ram: *mut u32, register: *mut u32, number: u32) -> u32;)*
        }

        /// All sequences, in the order of the figures.
        pub static SEQUENCES: [Sequence; [$($name),*].len()] = [$(Sequence {
            name: $name.as_ptr(),
            length: $name.len(),
            code: $symbol,
            register: Register::$register,
        }),*];
    };
}

sequences! {
    Ahb "empty" cyccnt_empty: "";
    Ahb "4 narrow nop" cyccnt_nop_4: "nop; nop; nop; nop";
    Ahb "16 narrow nop" cyccnt_nop_16: ".rept 16; nop; .endr";
    Ahb "16 wide add" cyccnt_add_16: ".rept 16; add.w r0, r0, r3; .endr";
    Ahb "nop, 15 wide add, not aligned" cyccnt_add_15: "nop; .rept 15; add.w r0, r0, r3; .endr";
    Ahb "load" cyccnt_ldr: "nop; ldr r0, [r1]; nop";
    Ahb "4 loads" cyccnt_ldr_4: "nop; ldr r0, [r1]; ldr r3, [r1]; ldr r0, [r1]; ldr r3, [r1]; nop";
    Ahb "load, load of its address" cyccnt_ldr_ldr: "nop; str r1, [r1]; ldr r0, [r1]; ldr r0, [r0]; nop";
    Ahb "add, load of its address" cyccnt_add_ldr: "nop; adds r0, r1, #0; ldr r0, [r0]; nop";
    Ahb "store" cyccnt_str: "nop; str r3, [r1]; nop";
    Ahb "store by register" cyccnt_str_register: "nop; str r3, [r1, r5]; nop";
    Ahb "store by register, load" cyccnt_str_ldr: "nop; str r3, [r1, r5]; ldr r0, [r1]; nop";
    Ahb "load, store by register" cyccnt_ldr_str: "nop; ldr r0, [r1]; str r3, [r1, r5]; nop";
    Ahb "literal load" cyccnt_literal: "nop; ldr r0, =0x12345678; nop";
    Ahb "4 literal loads" cyccnt_literal_4: "nop; ldr r0, =0x12345678; ldr r0, =0x12345678; ldr r0, =0x12345678; ldr r0, =0x12345678; nop";
    Ahb "load of 4 registers" cyccnt_ldm: "nop; ldmia r1, {{r0, r1, r2, r3}}; nop";
    Ahb "push and pop of 4 registers" cyccnt_push: "nop; push {{r0, r1, r2, r3}}; pop {{r0, r1, r2, r3}}; nop";
    Ahb "unaligned load" cyccnt_unaligned: "nop; ldr.w r0, [r1, #1]; nop";
    Ahb "branch in the line" cyccnt_branch_near: "b 2f; nop; 2: nop";
    Ahb "branch to a wide instruction in two lines" cyccnt_branch_wide: "b 2f; nop; nop; nop; nop; nop; 2: add.w r0, r0, r3; nop";
    Ahb "branch to the line behind" cyccnt_branch_next: "b 2f; nop; nop; nop; 2: nop";
    Ahb "branch over 4 lines" cyccnt_branch_far: "b 2f; .rept 16; nop; .endr; 2: nop";
    Ahb "branch that is not taken" cyccnt_branch_not: "cmp r5, #1; beq 2f; nop; 2: nop";
    Ahb "loop of 10" cyccnt_loop: "movs r0, #10; 2: subs r0, #1; bne 2b";
    Ahb "call and return" cyccnt_call: "b 3f; 2: bx lr; 3: bl 2b; nop";
    Ahb "IT, 2 instructions" cyccnt_it: "cmp r5, #0; itt eq; addeq r0, r3; addeq r0, r3; nop";
    Ahb "table branch" cyccnt_tbb: "tbb [pc, r5]; .short 1; 2: nop";
    Ahb "MLA" cyccnt_mla: "nop; mla r0, r3, r3, r1; nop";
    Ahb "UMULL, large" cyccnt_umull: "nop; umull r0, r12, r3, r3; nop";
    Ahb "UMULL, 16 bits" cyccnt_umull_small: "movw r0, #0xFFFF; umull r0, r12, r0, r0; nop";
    Ahb "UMULL, 8 bits" cyccnt_umull_byte: "movs r0, #255; umull r0, r12, r0, r0; nop";
    Ahb "SMLAL, large" cyccnt_smlal: "nop; smlal r0, r12, r3, r3; nop";
    Ahb "UDIV, quotient of 32 bits" cyccnt_udiv_32: "mvns r0, r5; movs r2, #1; udiv r0, r0, r2; nop";
    Ahb "UDIV, quotient of 16 bits" cyccnt_udiv_16: "movw r0, #0xFFFF; movs r2, #1; udiv r0, r0, r2; nop";
    Ahb "UDIV, quotient of 4 bits" cyccnt_udiv_4: "movs r0, #15; movs r2, #1; udiv r0, r0, r2; nop";
    Ahb "UDIV, quotient 0" cyccnt_udiv_0: "movs r0, #1; udiv r0, r0, r3; nop";
    Ahb "MRS" cyccnt_mrs: "nop; mrs r0, primask; nop";
    Ahb "CPSID, CPSIE" cyccnt_cps: "nop; cpsid i; cpsie i; nop";
    Ahb "DMB" cyccnt_dmb: "nop; dmb sy; nop";
    Ahb "ISB" cyccnt_isb: "nop; isb sy; nop";
    Apb1 "load from APB1" cyccnt_ldr_apb1: "nop; ldr r0, [r2]; nop";
    Apb1 "4 loads from APB1" cyccnt_ldr_4_apb1: "nop; ldr r0, [r2]; ldr r0, [r2]; ldr r0, [r2]; ldr r0, [r2]; nop";
    Apb1 "store to APB1" cyccnt_str_apb1: "nop; str r5, [r2]; nop; nop; nop; nop; nop; nop; nop; nop";
    Apb1 "4 stores to APB1" cyccnt_str_4_apb1: "nop; str r5, [r2]; str r5, [r2]; str r5, [r2]; str r5, [r2]; nop";
    Apb1 "store to APB1, load from RAM" cyccnt_str_apb1_ldr: "nop; str r5, [r2]; ldr r0, [r1]; nop";
    Apb2 "load from APB2" cyccnt_ldr_apb2: "nop; ldr r0, [r2]; nop";
    Apb2 "4 stores to APB2" cyccnt_str_4_apb2: "nop; str r5, [r2]; str r5, [r2]; str r5, [r2]; str r5, [r2]; nop";
    Ahb "load from the AHB" cyccnt_ldr_ahb: "nop; ldr r0, [r2]; nop";
}

#!/usr/bin/env python3
"""Checks that the archives of the cores need nothing impure: no clock, thread, environment, random
device, stream, file or socket. Everything undefined in an archive must be on the allow-list below.

usage: purity.py ARCHIVE...      exit 1 and one line per symbol that is not allowed
"""
import re
import subprocess
import sys

ALLOWED = [
    # ours, and what the linker makes of it; another core is refused by layering.py
    r"(vtable|typeinfo|typeinfo name|guard variable|VTT|non-virtual thunk to|virtual thunk to) (for )?gw::",
    r"([\w:<>*& ,]+ )?gw::",
    r"_GLOBAL_OFFSET_TABLE_",
    # the language: memory, exceptions, virtual tables, reference counts
    r"operator (new|delete)(\[\])?\(",
    r"__cxa_(allocate_exception|begin_catch|bad_cast|call_unexpected|end_catch|free_exception|guard_\w+|init_primary_exception"
    r"|pure_virtual|rethrow|throw|throw_bad_array_new_length)$",
    r"_Unwind_Resume$|__gxx_personality_v0$|__dynamic_cast$|__libc_single_threaded$|__stack_chk_fail$",
    r"(vtable|typeinfo) for (__cxxabiv1::|std::(bad_\w+|exception|logic_error|runtime_error|invalid_argument|out_of_range)$)",
    # which instructions the processor has (ADR 54): all of a result's forms are equal
    r"__cpu_(model|indicator_init)$",
    # GW_CHECK's last words
    r"(abort|__assert_fail|fprintf|fwrite|stderr)$",
    # the C library's pure functions
    r"(malloc|calloc|realloc|free|aligned_alloc|posix_memalign)$",
    r"(__)?(mem(chr|cmp|cpy|move|set)|str(len|cmp|ncmp|chr)|bcmp|v?snprintf|qsort|__isoc99_sscanf)(_chk)?$|crc32(_z)?$",
    r"(a?(sin|cos|tan)h?|atan2|sincos|exp2?|expm1|log(2|10|1p)?|pow|sqrt|cbrt|hypot|l?l?(round|rint)|nearbyint|floor|ceil"
    r"|trunc|fmod|remainder|erfc?|fma|fmin|fmax|modf|frexp|ldexp|cabs|carg|__muldc3)f?$",
    # the standard library's pure parts
    r"std::__throw_",
    r"std::_Rb_tree_|std::__detail::_(Prime_rehash_policy|List_node_base)|std::_Hash_bytes\(",
    r"std::__cxx11::basic_string<|std::(to_chars|from_chars)\(|std::(terminate\(\)|nothrow)",
    r"std::(bad_\w+|exception|logic_error|runtime_error|invalid_argument|out_of_range)::",
    # the solver and OpenCV's arithmetic; not their clocks, threads, files or generators
    r"((void|bool|int|double) |typeinfo for |vtable for )?ceres::",
    r"((void|typeinfo for|vtable for) )?cv::(?!theRNG|RNG|rand|getTick|getCPU|TickMeter|setNum|getNum|parallel_for"
    r"|im(read|write|dec|enc)|FileStorage|VideoC|utils::)",
]
ALLOWED_PATTERN = re.compile("|".join(f"(?:{pattern})" for pattern in ALLOWED))


def undefined_symbols(archive):
    out = subprocess.run(["nm", "-u", "-C", archive], capture_output=True, text=True, check=True).stdout
    member = ""
    for line in out.splitlines():
        symbol = re.match(r"\s+[Uvw] (.+)$", line)
        if symbol:
            yield member, symbol.group(1)
        elif line.endswith(":"):
            member = line[:-1]


def main():
    archives = sys.argv[1:]
    if not archives:
        print(__doc__, file=sys.stderr)
        return 2
    violations = sorted({f"{archive}: {member} needs {symbol}"
                         for archive in archives
                         for member, symbol in undefined_symbols(archive)
                         if not ALLOWED_PATTERN.match(symbol)})
    print("\n".join(violations) if violations else f"purity: ok ({len(archives)} archives)")
    return 1 if violations else 0


if __name__ == "__main__":
    sys.exit(main())

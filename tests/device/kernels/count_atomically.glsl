// All lanes meet on the same words; each takes a ticket, and no ticket may be missing or taken
// twice.

void count_atomically(int group, int lane) {
    int i = lane_index(group, lane);
    int ticket = ATOMIC_ADD(result[0], 1);
    block_flags[ticket] += 1;
    ATOMIC_MAX(result[1], i);
    ATOMIC_MAX(result[2], -1 - i);
    ATOMIC_OR(result[3], 1 << (lane & 31));
    if (ATOMIC_LOAD(result[0]) <= ticket) {
        ATOMIC_ADD(result[4], 1);  // a count that went backwards
    }
}

// All lanes meet on the same words; each takes a ticket, and no ticket may be missing or taken
// twice.

void count_atomically(int group, int lane) {
    int i = lane_index(group, lane);
    int ticket = ATOMIC_ADD(counts[0], 1);
    tickets[ticket] += 1;
    ATOMIC_MAX(counts[1], i);
    ATOMIC_MAX(counts[2], -1 - i);
    ATOMIC_OR(counts[3], 1 << (lane & 31));
    if (ATOMIC_LOAD(counts[0]) <= ticket) {
        ATOMIC_ADD(counts[4], 1);  // a count that went backwards
    }
}

int count_atomically_lanes(int group, int half_at) { return kAllLanes; }

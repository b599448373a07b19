// Each group counts its lanes and notes its entry of entries.

void mark_groups(int group, int lane) {
    ATOMIC_ADD(counts[2 * group], 1);
    if (lane == 63) counts[2 * group + 1] = entries[params.list_offset + group];
}

int mark_groups_lanes(int group, int half_at) { return kAllLanes; }

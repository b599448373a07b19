// Each group counts its lanes and notes its entry of block_list.

void mark_groups(int group, int lane) {
    ATOMIC_ADD(result[2 * group], 1);
    if (lane == 63) {
        result[2 * group + 1] = block_list[params.list_offset + group];
    }
}

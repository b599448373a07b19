// Where the soil's momentum comes from and goes to, counted as it happens: see kResultFallen. Whatever changes the momentum planes
// but by moving soil calls these.

// Adds to three 64-bit sums.
void add_momentum_sum(int at, ivec3 momentum) {
    if (momentum.x != 0) add_wide(at, momentum.x);
    if (momentum.y != 0) add_wide(at + 2, momentum.y);
    if (momentum.z != 0) add_wide(at + 4, momentum.z);
}

// Momentum that a body has given soil.
void note_given(int body, ivec3 momentum) { add_momentum_sum(kResultHeader + body * kLoadWords + kLoadImpulse, momentum); }

// The ground gives a voxel's soil another momentum, or takes it.
void set_by_ground(int voxel, ivec3 momentum) {
    add_momentum_sum(kResultGround, momentum_at(voxel) - momentum);
    set_state(kPlaneMomentumX, voxel, momentum.x);
    set_state(kPlaneMomentumY, voxel, momentum.y);
    set_state(kPlaneMomentumZ, voxel, momentum.z);
}

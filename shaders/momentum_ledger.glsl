// Where the soil's momentum comes from and goes to, counted as it happens: see kResultFallen. Whatever changes the momentum planes
// but by moving soil calls these.

// Along an axis. Beyond a speed of `most` it is the most that there is, which apply_flow reports.
int momentum_along(int half_mass, int speed, int most) {
    return abs(speed) > most ? sign(speed) * kMomentumMost : mul_q16(half_mass, speed * 2);
}

// Speed beyond which a mass has more than kMomentumMost, Q16 voxels a base step: twice that is within 31 bits.
int fastest_of(int mass) { return min(kMomentumMost / max(1, mass), 2 * kCrumbSpeedMost) * 64; }

// 4 voxels of 2000 kg/m3 have more than kMomentumMost from 8 voxels a base step on.
ivec3 momentum_of(int mass, ivec3 velocity) {
    int counted = min(mass, kMassMost);
    int most = fastest_of(counted);
    int half_mass = counted * (kVelocityOne / 2);
    return ivec3(momentum_along(half_mass, velocity.x, most), momentum_along(half_mass, velocity.y, most),
                 momentum_along(half_mass, velocity.z, most));
}

CONST_INT(kFineUnits, 16384)  // mass units times Q24 in a unit of momentum

// The same along an axis, of a speed with 8 bits more (Q24 voxels a base step), to the nearest unit.
int fine_momentum(int mass, int speed) {
    int counted = min(mass, kMassMost);
    int whole = abs(speed) / kOneQ8;
    int rest = (abs(speed) & (kOneQ8 - 1)) * counted + int((uint(counted) * uint(whole)) & 63u) * kOneQ8;
    int momentum = momentum_along(counted * (kVelocityOne / 2), whole, fastest_of(counted));
    return sign(speed) * saturated_sum(momentum, (rest + kFineUnits / 2) / kFineUnits);
}

// 64-bit sum in two words. Adding commutes, so the result does not depend on the order.
void add_wide(int at, int value) {
    uint old = uint(ATOMIC_ADD(result[at], value));
    int carry = (old + uint(value) < old ? 1 : 0) - (value < 0 ? 1 : 0);
    if (carry != 0) ATOMIC_ADD(result[at + 1], carry);
}

// Adds to three 64-bit sums.
void add_momentum_sum(int at, ivec3 momentum) {
    if (momentum.x != 0) add_wide(at, momentum.x);
    if (momentum.y != 0) add_wide(at + 2, momentum.y);
    if (momentum.z != 0) add_wide(at + 4, momentum.z);
}

// Momentum that a body has given soil.
void note_given(int body, ivec3 momentum) { add_momentum_sum(kResultHeader + body * kLoadWords + kLoadImpulse, momentum); }

void set_momentum(int voxel, ivec3 momentum) {
    set_state(kPlaneMomentumX, voxel, momentum.x);
    set_state(kPlaneMomentumY, voxel, momentum.y);
    set_state(kPlaneMomentumZ, voxel, momentum.z);
}

// The ground gives a voxel's soil another momentum, or takes it.
void set_by_ground(int voxel, ivec3 momentum) {
    add_momentum_sum(kResultGround, saturated(momentum_at(voxel), -momentum));
    set_momentum(voxel, momentum);
}

// A sum over the voxels of a column, which goes to the ledger at once: all lanes wait for its words. In halves, because a few
// voxels can have more momentum than 31 bits hold.
struct MomentumSum {
    ivec3 high;  // times 2^16
    ivec3 low;
};

MomentumSum no_momentum() {
    MomentumSum sum;
    sum.high = ivec3(0);
    sum.low = ivec3(0);
    return sum;
}

void add_to_sum(INOUT(MomentumSum) sum, ivec3 momentum) {
    sum.high += momentum >> 16;
    sum.low += momentum & kLowHalf;
}

void add_wide_halves(int at, int high, int low) {
    uint upper = uint(high >> 16);
    uint word = uint(high) << 16;
    uint lower = word + uint(low);
    if (lower < word) upper += 1u;
    uint old = lower == 0u ? 0u : uint(ATOMIC_ADD(result[at], int(lower)));
    if (old + lower < old) upper += 1u;
    if (upper != 0u) ATOMIC_ADD(result[at + 1], int(upper));
}

void add_momentum_sums(int at, IN(MomentumSum) sum) {
    add_wide_halves(at, sum.high.x, sum.low.x);
    add_wide_halves(at + 2, sum.high.y, sum.low.y);
    add_wide_halves(at + 4, sum.high.z, sum.low.z);
}

// As set_by_ground(), for one voxel of several.
void set_in_sum(int voxel, ivec3 momentum, INOUT(MomentumSum) taken) {
    add_to_sum(taken, momentum_at(voxel) - momentum);
    set_momentum(voxel, momentum);
}

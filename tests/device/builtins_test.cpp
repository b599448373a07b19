/// The kernel language means the same, bit for bit, in C++ and in GLSL.
#include <bit>
#include <cmath>
#include <limits>
#include <random>

#include "device_fixture.h"

namespace bsoil::device::builtins_test {
namespace {

constexpr int kPlanes = 11;
enum Plane { kMul, kSqrt, kInvSqrt, kQuotient = 8, kWholeRoot = 10 };

constexpr int kMin = std::numeric_limits<int>::min();
constexpr int kMax = std::numeric_limits<int>::max();

/// Runs probe_builtins over pairs (padded to whole groups); plane p of pair i is at p * stride + i.
struct Probe {
    explicit Probe(std::vector<int32_t> pair_list) : pairs(std::move(pair_list)) {
        const size_t pairs_per_group = 2 * kLanesPerGroup;
        pairs.resize((pairs.size() + pairs_per_group - 1) / pairs_per_group * pairs_per_group,
                     std::bit_cast<int32_t>(1.0f));
        stride = static_cast<int>(pairs.size() / 2);
    }

    std::vector<int32_t> run(Device& device) const {
        EXPECT_TRUE(device.allocate(Buffer::inputs, std::ssize(pairs)));
        EXPECT_TRUE(device.allocate(Buffer::outputs, int64_t{kPlanes} * stride));
        device.write(Buffer::inputs, 0, pairs);
        TestParams params{};
        params.stride = stride;
        dispatch(device, probe_builtins, plain_work(stride / kLanesPerGroup), params);
        return read_words(device, Buffer::outputs, int64_t{kPlanes} * stride);
    }

    std::vector<int32_t> pairs;
    int stride = 0;
};

std::vector<int32_t> extreme_pairs() {
    const int values[] = {0,     1,      -1,      2,          -2,    3,        65535, 65536,
                          65537, -65535, -65536,  -65537,     kMin,  kMin + 1, kMax,  kMax - 1,
                          12345, -54321, 1 << 30, -(1 << 30), 46341, -46341,   32768, -32768};
    std::vector<int32_t> pairs;
    for (const int a : values) {
        for (const int b : values) pairs.insert(pairs.end(), {a, b});
    }
    return pairs;
}

std::vector<int32_t> random_pairs(int count) {
    std::mt19937 random(7);
    std::vector<int32_t> pairs;
    for (int i = 0; i < 2 * count; ++i) pairs.push_back(static_cast<int32_t>(random()));
    return pairs;
}

/// Positive floats over the range in which the roots are promised, evenly over the exponents.
std::vector<int32_t> random_float_pairs(int count) {
    std::mt19937 random(11);
    std::uniform_int_distribution<int> bits(std::bit_cast<int>(0x1p-96f),
                                            std::bit_cast<int>(0x1p126f));
    std::vector<int32_t> pairs;
    for (int i = 0; i < 2 * count; ++i) pairs.push_back(bits(random));
    return pairs;
}

TEST_P(AnyDevice, mul_q16_is_the_floor_of_the_64_bit_product) {
    const Probe probe(extreme_pairs());
    const auto planes = probe.run(*device_);
    for (int i = 0; i < probe.stride; ++i) {
        const int64_t product = int64_t{probe.pairs[2 * i]} * probe.pairs[2 * i + 1];
        const int64_t quotient = product / 65536 - (product % 65536 < 0 ? 1 : 0);
        // Beyond 32 bits the low word remains.
        ASSERT_EQ(planes[i], static_cast<int32_t>(quotient))
            << probe.pairs[2 * i] << " * " << probe.pairs[2 * i + 1];
    }
}

TEST_P(AnyDevice, roots_are_within_2e_7_of_double_precision) {
    const Probe probe(random_float_pairs(100'000));
    const auto planes = probe.run(*device_);
    // Three roundings of 6e-8 each at most.
    constexpr double kTolerance = 2e-7;
    for (int i = 0; i < probe.stride; ++i) {
        const double x = std::bit_cast<float>(probe.pairs[2 * i]);
        const double root = std::bit_cast<float>(planes[kSqrt * probe.stride + i]);
        const double inverse = std::bit_cast<float>(planes[kInvSqrt * probe.stride + i]);
        ASSERT_NEAR(root / std::sqrt(x), 1, kTolerance) << x;
        ASSERT_NEAR(inverse * std::sqrt(x), 1, kTolerance) << x;
    }
}

TEST_P(AnyDevice, roots_of_perfect_squares_are_whole) {
    std::vector<int32_t> pairs;
    for (int n = 1; n <= 4096; ++n) {  // up to 4096^2 = 2^24 floats hold every integer
        pairs.insert(pairs.end(), {std::bit_cast<int32_t>(static_cast<float>(n * n)), 0});
    }
    const Probe probe(pairs);
    const auto planes = probe.run(*device_);
    for (int n = 1; n <= 4096; ++n) {
        ASSERT_EQ(std::bit_cast<float>(planes[kSqrt * probe.stride + n - 1]),
                  static_cast<float>(n));
    }
}

TEST_P(AnyDevice, roots_of_zero_tiny_and_negative_numbers_are_zero) {
    const float values[] = {0.0f, -0.0f, -1.0f, -1e30f, 1e-40f, 0x1p-97f};
    std::vector<int32_t> pairs;
    for (const float value : values) pairs.insert(pairs.end(), {std::bit_cast<int32_t>(value), 0});
    const Probe probe(pairs);
    const auto planes = probe.run(*device_);
    for (size_t i = 0; i < std::size(values); ++i) {
        EXPECT_EQ(std::bit_cast<float>(planes[kSqrt * probe.stride + i]), 0.0f) << values[i];
        EXPECT_EQ(planes[kInvSqrt * probe.stride + i], 0) << values[i];
    }
}

TEST_P(AnyDevice, quotients_are_rounded_to_the_nearest_float) {
    const Probe probe(random_pairs(100'000));
    const auto planes = probe.run(*device_);
    for (int i = 0; i < probe.stride; ++i) {
        // As probe_builtins has them.
        const float u = static_cast<float>(probe.pairs[2 * i] >> 12) * 0.001f;
        const float v = static_cast<float>(probe.pairs[2 * i + 1] >> 12) * 0.37f;
        const float whole = v + (v < 0 ? -1.5f : 1.5f);
        const double quotient = double{u} / double{whole};
        ASSERT_EQ(std::bit_cast<float>(planes[kQuotient * probe.stride + i]),
                  static_cast<float>(quotient))
            << u << " / " << whole;
    }
}

TEST_P(AnyDevice, whole_roots_are_rounded_down) {
    std::vector<int32_t> pairs = random_pairs(50'000);
    for (int root = 1; root <= 46340; root += root < 46000 ? 97 : 1) {  // 46340^2 is the largest
        for (const int beside : {-1, 0, 1}) pairs.insert(pairs.end(), {root * root + beside, 0});
    }
    pairs.insert(pairs.end(), {kMax, 0, kMax - 1, 0});
    const Probe probe(pairs);
    const auto planes = probe.run(*device_);
    for (int i = 0; i < probe.stride; ++i) {
        const int square = probe.pairs[2 * i] & kMax;
        const int64_t root = planes[kWholeRoot * probe.stride + i];
        ASSERT_LE(root * root, square);
        ASSERT_GT((root + 1) * (root + 1), square);
    }
}

TEST_P(AnyDevice, every_builtin_gives_the_bits_of_the_cpu) {
    const auto cpu = create_cpu_device(test_kernel_set(), 1);
    for (const auto& pairs : {extreme_pairs(), random_pairs(50'000), random_float_pairs(50'000)}) {
        const Probe probe(pairs);
        const auto here = probe.run(*device_), there = probe.run(*cpu);
        for (int plane = 0; plane < kPlanes; ++plane) {
            const auto first = here.begin() + plane * probe.stride;
            const auto differs =
                std::mismatch(first, first + probe.stride, there.begin() + plane * probe.stride);
            const auto i = differs.first - first;
            EXPECT_EQ(i, probe.stride)
                << "plane " << plane << ": " << *differs.first << " for " << *differs.second
                << " of " << probe.pairs[2 * i] << ", " << probe.pairs[2 * i + 1];
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Builtins, AnyDevice,
                         testing::Values("cpu1", "cpu2", "gl", "gl_as_hardware"),
                         [](const auto& device) { return device.param; });

}  // namespace
}  // namespace bsoil::device::builtins_test

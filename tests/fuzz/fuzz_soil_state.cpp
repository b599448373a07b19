#include "bsoil/soil.h"
#include "targets.h"

namespace bsoil::fuzz {
namespace {

/// A soil of 24 x 12 x 16 voxels, two materials, terrain and a box that moves through it.
class SmallSoil {
  public:
    SmallSoil() {
        SoilDef def;
        def.materials = {materials::dry_sand(), materials::clay()};
        def.up = UpAxis::z;
        def.size_m = {2.4, 1.2, 1.6};
        def.voxel_m = 0.1;
        def.backend = Backend::cpu;
        def.thread_count = 1;
        auto made = Soil::create(def);
        require(made.ok(), "no soil");
        soil_ = std::move(*made);
        const auto check = [](const Status& status) { require(status.ok(), "the fill fails"); };
        check(soil_->add_terrain([](Vec3 p) { return 0.2 - p.z + 0.2 * p.x; }));
        check(soil_->fill(BoxFill{{{-1.2, -0.6, 0}, {1.2, 0.6, 0.7}}, "dry_sand"}));
        check(soil_->fill(CylinderFill{{0.3, 0, 0.7}, 0.3, 0.6, "clay"}));
        ConvexShape box;
        box.half_extents_m = {0.2, 0.3, 0.2};
        shapes_.push_back(box);
        for (int i = 0; i < 6; ++i) step();
        good_ = soil_->state();
    }

    void step() {
        SoilBody body;
        body.pose.position = {-0.6 + 0.03 * step_count_++, 0, 0.7};
        body.center_of_mass_m = body.pose.position;
        body.linear_velocity_m_s = {1.8, 0, 0};
        body.shapes = &shapes_;
        soil_->step({&body, 1});
    }

    /// Puts a state in and goes on from it; a bad one has to leave things as they are.
    void try_state(Bytes state) {
        step_count_ = 6;
        const uint64_t before = soil_->checksum();
        const auto put = soil_->prepare(state);
        if (!put) {
            require(!put.error().empty(), "an error without a text");
            require(soil_->checksum() == before, "a refused state has changed the soil");
            return;
        }
        (*put)();
        const std::vector<int64_t> units = soil_->totals().units;
        for (int i = 0; i < 3; ++i) {
            step();
            require(soil_->totals().units == units, "soil is not conserved");
        }
        const std::vector<uint8_t> again = soil_->state();
        require(soil_->prepare(again).ok(), "the soil refuses a state of its own");
    }

    const std::vector<uint8_t>& good() const { return good_; }

  private:
    std::unique_ptr<Soil> soil_;
    std::vector<ConvexShape> shapes_;
    std::vector<uint8_t> good_;
    int step_count_ = 0;
};

}  // namespace

void fuzz_soil_state(Bytes bytes) {
    static SmallSoil soil;
    std::vector<uint8_t> state = soil.good();
    Choices choices(bytes);
    edit(state, choices);
    soil.try_state(state);
    soil.try_state(soil.good());
}

}  // namespace bsoil::fuzz

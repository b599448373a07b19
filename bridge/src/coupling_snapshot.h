/// CouplingSnapshot: what the coupling remembers of its bodies, as bytes and back.
#pragma once

#include <memory>

#include "body_collector.h"
#include "bsoil/host/ground_surface.h"
#include "bsoil/snapshot_file.h"
#include "carried_load.h"
#include "contact_coupling.h"
#include "first_contact.h"
#include "sleeping_loads.h"
#include "soil_vehicles.h"

namespace bsoil::bullet {

/// Objects are named by their place in the world's list, vehicles by their raycasters' order.
class CouplingSnapshot {
  public:
    struct Parts {
        const btDiscreteDynamicsWorld& world;
        BodyCollector& collector;
        ContactCoupling& coupling;
        CarriedLoads& carried;
        SleepingLoads& sleeping;
        FirstContacts& first_contacts;
        SoilVehicles& vehicles;
        GroundSurface& surface;
    };
    /// What the parts remember now. Between substeps.
    static CouplingSnapshot of(const Parts& parts);
    CouplingSnapshot();
    CouplingSnapshot(CouplingSnapshot&&) noexcept;
    ~CouplingSnapshot();

    /// Reads or writes; refuses what does not fit the world.
    void serialize(StateStream& stream, const btDiscreteDynamicsWorld& world);
    /// Error: raycast vehicles are not those whose wheels the snapshot holds; it names the first.
    Status check_same_vehicles(const SoilVehicles& here) const;
    /// Error: a body carries, owes or pays more than the soil's whole grid can hold or give; it
    /// names the first.
    Status check_loads(const Soil& soil) const;
    /// Replaces what the parts remember. Once, of a snapshot that has been read and fits.
    void put_into(const Parts& parts);

  private:
    struct Memory;
    std::unique_ptr<Memory> memory_;
};

}  // namespace bsoil::bullet

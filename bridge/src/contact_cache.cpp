#include "contact_cache.h"

#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>
#include <BulletCollision/CollisionShapes/btCollisionShape.h>

#include <algorithm>
#include <functional>
#include <unordered_map>
#include <utility>

#include "bullet_stream.h"
#include "pair_algorithms.h"

namespace bsoil::bullet {
namespace {

using bullet::list;

constexpr int kStages = btDbvtBroadphase::STAGECOUNT;
constexpr int32_t kInternalNode = -1;  ///< in place of a leaf's object

/// Bullet lets only worlds of the host's own class at these.
struct PredictiveContacts : btDiscreteDynamicsWorld {
    static void release_predictive_contacts(btDiscreteDynamicsWorld& world) {
        (world.*(&PredictiveContacts::releasePredictiveContacts))();
    }
};

void list(StateStream& stream, btManifoldPoint& p) {
    for (btVector3* v :
         {&p.m_localPointA, &p.m_localPointB, &p.m_positionWorldOnB, &p.m_positionWorldOnA,
          &p.m_normalWorldOnB, &p.m_lateralFrictionDir1, &p.m_lateralFrictionDir2}) {
        list(stream, *v);
    }
    stream(p.m_distance1, p.m_combinedFriction, p.m_combinedRollingFriction,
           p.m_combinedSpinningFriction, p.m_combinedRestitution, p.m_partId0, p.m_partId1,
           p.m_index0, p.m_index1, p.m_contactPointFlags, p.m_appliedImpulse, p.m_prevRHS,
           p.m_appliedImpulseLateral1, p.m_appliedImpulseLateral2, p.m_contactMotion1,
           p.m_contactMotion2, p.m_contactCFM, p.m_contactERP, p.m_frictionCFM, p.m_lifeTime);
}

/// Bullet's own leaves the count as it was.
void clear(btDbvt& tree) {
    tree.clear();
    tree.m_leaves = 0;
}

class ContactCache {
  public:
    ContactCache(StateStream& stream, btDiscreteDynamicsWorld& world)
        : stream_(stream),
          world_(world),
          objects_(world.getCollisionObjectArray()),
          broadphase_(*dynamic_cast<btDbvtBroadphase*>(world.getBroadphase())),
          pairs_(*broadphase_.getOverlappingPairCache()),
          dispatcher_(*dynamic_cast<btCollisionDispatcher*>(world.getDispatcher())) {}

    void serialize();

  private:
    using ObjectIndex = int32_t;

    void serialize_proxies();
    void serialize_stages();
    void serialize_tree(int set);
    void write_tree(const btDbvt& tree);
    void read_tree(btDbvt& tree, int set);
    void serialize_pairs();
    void serialize_manifolds();
    void serialize_points(btPersistentManifold& manifold);
    void empty_broadphase();
    void repair();

    btCollisionObject* object(ObjectIndex index) {
        return index >= 0 && index < objects_.size() ? objects_[index] : nullptr;
    }
    btDbvtProxy* proxy(ObjectIndex index) {
        btCollisionObject* found = object(index);
        return found ? static_cast<btDbvtProxy*>(found->getBroadphaseHandle()) : nullptr;
    }
    ObjectIndex index_of(const btBroadphaseProxy* of) const {
        const auto found = index_.find(of->m_clientObject);
        return found == index_.end() ? -1 : found->second;
    }

    StateStream& stream_;
    btDiscreteDynamicsWorld& world_;
    btCollisionObjectArray& objects_;
    btDbvtBroadphase& broadphase_;
    btOverlappingPairCache& pairs_;
    btCollisionDispatcher& dispatcher_;
    std::unordered_map<const void*, ObjectIndex> index_;
};

void ContactCache::serialize() {
    for (int i = 0; i < objects_.size(); ++i) index_[objects_[i]] = i;
    // They live from the start of one substep to that of the next, which would release them.
    PredictiveContacts::release_predictive_contacts(world_);
    if (stream_.reads()) empty_broadphase();
    for (int i = 0; i < pairs_.getNumOverlappingPairs() && !stream_.reads(); ++i) {
        renew_algorithm(world_, pairs_.getOverlappingPairArray()[i]);
    }
    serialize_proxies();
    for (int set = 0; set < 2; ++set) serialize_tree(set);
    serialize_stages();
    btDbvtBroadphase& b = broadphase_;
    stream_(b.m_stageCurrent, b.m_fupdates, b.m_dupdates, b.m_cupdates, b.m_newpairs, b.m_fixedleft,
            b.m_updates_call, b.m_updates_done, b.m_updates_ratio, b.m_pid, b.m_cid, b.m_gid,
            b.m_needcleanup);
    const auto is_percent = [](int share) { return share >= 0 && share <= 100; };
    if (b.m_stageCurrent < 0 || b.m_stageCurrent >= kStages || b.m_cid < 0 || b.m_gid < 0 ||
        !is_percent(b.m_fupdates) || !is_percent(b.m_dupdates) || !is_percent(b.m_cupdates)) {
        stream_.refuse();
    }
    if (stream_.good()) serialize_pairs();
    if (stream_.good()) serialize_manifolds();
    if (stream_.reads() && !stream_.good()) repair();
}

void ContactCache::empty_broadphase() {
    for (int i = 0; i < objects_.size(); ++i) {
        btBroadphaseProxy* old = objects_[i]->getBroadphaseHandle();
        pairs_.cleanProxyFromPairs(old, &dispatcher_);
    }
    const bool deferred = broadphase_.m_deferedcollide;
    broadphase_.m_deferedcollide = true;  // no pairs yet
    for (int i = 0; i < objects_.size(); ++i) {
        const btBroadphaseProxy old = *objects_[i]->getBroadphaseHandle();
        broadphase_.destroyProxy(objects_[i]->getBroadphaseHandle(), &dispatcher_);
        objects_[i]->setBroadphaseHandle(broadphase_.createProxy(
            old.m_aabbMin, old.m_aabbMax, objects_[i]->getCollisionShape()->getShapeType(),
            objects_[i], old.m_collisionFilterGroup, old.m_collisionFilterMask, &dispatcher_));
    }
    broadphase_.m_deferedcollide = deferred;
}

void ContactCache::serialize_proxies() {
    std::vector<int> ids;
    for (int i = 0; i < objects_.size() && stream_.good(); ++i) {
        btDbvtProxy& p = *proxy(i);
        list(stream_, p.m_aabbMin);
        list(stream_, p.m_aabbMax);
        stream_(p.m_uniqueId, p.m_collisionFilterGroup, p.m_collisionFilterMask, p.stage);
        if (p.stage < 0 || p.stage > kStages || p.m_uniqueId < 0) {
            p.stage = 0;
            stream_.refuse();
        }
        ids.push_back(p.m_uniqueId);
    }
    std::sort(ids.begin(), ids.end());
    if (std::adjacent_find(ids.begin(), ids.end()) != ids.end()) stream_.refuse();
}

/// Each stage is a list of proxies, in the order in which they came to it.
void ContactCache::serialize_stages() {
    std::vector<bool> listed(static_cast<size_t>(objects_.size()), false);
    for (int stage = 0; stage <= kStages; ++stage) {
        std::vector<ObjectIndex> order;
        for (btDbvtProxy* p = stream_.reads() ? nullptr : broadphase_.m_stageRoots[stage]; p;
             p = p->links[1]) {
            order.push_back(index_of(p));
        }
        stream_(order);
        if (!stream_.reads()) continue;
        broadphase_.m_stageRoots[stage] = nullptr;
        btDbvtProxy* last = nullptr;
        for (const ObjectIndex index : order) {
            btDbvtProxy* p = proxy(index);
            if (!p || p->stage != stage || listed[static_cast<size_t>(index)]) {
                return stream_.refuse();
            }
            listed[static_cast<size_t>(index)] = true;
            p->links[0] = last;
            p->links[1] = nullptr;
            (last ? last->links[1] : broadphase_.m_stageRoots[stage]) = p;
            last = p;
        }
    }
    if (stream_.reads() && std::find(listed.begin(), listed.end(), false) != listed.end()) {
        stream_.refuse();
    }
}

void ContactCache::serialize_tree(int set) {
    btDbvt& tree = broadphase_.m_sets[set];
    if (stream_.reads()) {
        read_tree(tree, set);
    } else {
        write_tree(tree);
    }
    stream_(tree.m_lkhd, tree.m_opath);
}

/// Nodes from the root down, the first child's before the second's; and each one's rank by address,
/// since Bullet compares addresses when it improves a tree.
void ContactCache::write_tree(const btDbvt& tree) {
    int32_t leaves = tree.m_leaves;
    stream_(leaves);
    std::vector<btDbvtNode*> nodes, open;
    if (tree.m_root) open.push_back(tree.m_root);
    while (!open.empty()) {
        btDbvtNode* node = open.back();
        open.pop_back();
        nodes.push_back(node);
        if (node->isleaf()) continue;
        open.push_back(node->childs[1]);
        open.push_back(node->childs[0]);
    }
    std::vector<btDbvtNode*> sorted = nodes;
    std::sort(sorted.begin(), sorted.end(), std::less<>());
    for (btDbvtNode* node : nodes) {
        int32_t index =
            node->isinternal() ? kInternalNode : index_of(static_cast<btDbvtProxy*>(node->data));
        auto rank = static_cast<int32_t>(
            std::lower_bound(sorted.begin(), sorted.end(), node, std::less<>()) - sorted.begin());
        stream_(index, rank);
        list(stream_, node->volume.tMins());
        list(stream_, node->volume.tMaxs());
    }
}

void ContactCache::read_tree(btDbvt& tree, int set) {
    const auto in_set = [set](const btDbvtProxy& p) {
        return (p.stage == kStages) == (set == btDbvtBroadphase::FIXED_SET);
    };
    clear(tree);
    int32_t expected = 0, leaves = 0;
    for (int i = 0; i < objects_.size(); ++i) {
        if (!in_set(*proxy(i))) continue;
        proxy(i)->leaf = nullptr;
        ++expected;
    }
    stream_(leaves);
    if (!stream_.good() || leaves != expected) return stream_.refuse();
    if (leaves == 0) return;
    std::vector<btDbvtNode*> unused(static_cast<size_t>(2 * leaves - 1));
    for (btDbvtNode*& node : unused) node = new (btAlignedAlloc(sizeof(btDbvtNode), 16)) btDbvtNode;
    std::sort(unused.begin(), unused.end(), std::less<>());
    struct Gap {
        btDbvtNode* parent;
        int child;
    };
    std::vector<Gap> gaps{{nullptr, 0}};
    std::vector<btDbvtNode*> used;
    const auto make_node = [&](const Gap& gap) {
        int32_t index = kInternalNode, rank = 0;
        btVector3 low(0, 0, 0), high(0, 0, 0);
        stream_(index, rank);
        list(stream_, low);
        list(stream_, high);
        btDbvtProxy* of = index == kInternalNode ? nullptr : proxy(index);
        if (!stream_.good() || rank < 0 || static_cast<size_t>(rank) >= unused.size() ||
            !unused[static_cast<size_t>(rank)] ||
            (index != kInternalNode && (!of || !in_set(*of) || of->leaf))) {
            return false;
        }
        btDbvtNode* node = std::exchange(unused[static_cast<size_t>(rank)], nullptr);
        used.push_back(node);
        node->volume = btDbvtVolume::FromMM(low, high);
        node->parent = gap.parent;
        node->childs[0] = node->childs[1] = nullptr;
        (gap.parent ? gap.parent->childs[gap.child] : tree.m_root) = node;
        if (of) {
            node->data = of;
            of->leaf = node;
            ++tree.m_leaves;
        } else {
            gaps.push_back({node, 1});
            gaps.push_back({node, 0});
        }
        return true;
    };
    while (!gaps.empty() && used.size() < unused.size()) {
        const Gap gap = gaps.back();
        gaps.pop_back();
        if (!make_node(gap)) break;
    }
    if (gaps.empty() && used.size() == unused.size()) return;
    stream_.refuse();
    for (auto* nodes : {&used, &unused}) {
        for (btDbvtNode* node : *nodes) btAlignedFree(node);
    }
    tree.m_root = nullptr;
    tree.m_leaves = 0;
}

/// After bytes that were refused: whole again, though in no order that counts.
void ContactCache::repair() {
    for (btDbvt& tree : broadphase_.m_sets) clear(tree);
    for (btDbvtProxy*& root : broadphase_.m_stageRoots) root = nullptr;
    broadphase_.m_stageCurrent = 0;
    btDbvtProxy* last = nullptr;
    for (int i = 0; i < objects_.size(); ++i) {
        btDbvtProxy* p = proxy(i);
        if (pairs_.getNumOverlappingPairs() == 0) p->m_uniqueId = i + 1;
        p->leaf = broadphase_.m_sets[0].insert(btDbvtVolume::FromMM(p->m_aabbMin, p->m_aabbMax), p);
        p->stage = 0;
        p->links[0] = last;
        p->links[1] = nullptr;
        (last ? last->links[1] : broadphase_.m_stageRoots[0]) = p;
        last = p;
    }
}

void ContactCache::serialize_pairs() {
    btBroadphasePairArray& pairs = pairs_.getOverlappingPairArray();
    const size_t count = stream_.count(static_cast<size_t>(pairs.size()), 9);
    for (size_t i = 0; i < count && stream_.good(); ++i) {
        ObjectIndex a = 0, b = 0;
        bool has_algorithm = false;
        if (!stream_.reads()) {
            const btBroadphasePair& pair = pairs[static_cast<int>(i)];
            a = index_of(pair.m_pProxy0);
            b = index_of(pair.m_pProxy1);
            has_algorithm = pair.m_algorithm != nullptr;
        }
        stream_(a, b, has_algorithm);
        if (!stream_.reads()) continue;
        if (!proxy(a) || !proxy(b) || a == b || pairs_.findPair(proxy(a), proxy(b))) {
            return stream_.refuse();
        }
        btBroadphasePair* pair = pairs_.addOverlappingPair(proxy(a), proxy(b));
        if (!pair) return stream_.refuse();  // filtered
        if (has_algorithm) make_algorithm(world_, *pair);
    }
}

void ContactCache::serialize_points(btPersistentManifold& manifold) {
    int32_t count = manifold.getNumContacts();
    stream_(count);
    if (count < 0 || count > MANIFOLD_CACHE_SIZE) return stream_.refuse();
    if (stream_.reads()) {
        manifold.clearManifold();
        manifold.setNumContacts(count);
    }
    for (int i = 0; i < count; ++i) {
        if (stream_.reads()) manifold.getContactPoint(i) = btManifoldPoint();
        list(stream_, manifold.getContactPoint(i));
    }
}

/// In the dispatcher's order, which is the solver's.
void ContactCache::serialize_manifolds() {
    struct Place {
        int32_t pair = 0, number = 0;
    };
    const btBroadphasePairArray& pairs = pairs_.getOverlappingPairArray();
    std::unordered_map<const btPersistentManifold*, Place> places;
    std::vector<btManifoldArray> by_pair(static_cast<size_t>(pairs.size()));
    for (int i = 0; i < pairs.size(); ++i) {
        btManifoldArray& manifolds = by_pair[static_cast<size_t>(i)];
        manifolds = manifolds_of(pairs[i]);
        for (int m = 0; m < manifolds.size(); ++m) places[manifolds[m]] = {i, m};
    }
    int32_t count = dispatcher_.getNumManifolds();
    stream_(count);
    if (count != dispatcher_.getNumManifolds() || static_cast<size_t>(count) != places.size()) {
        return stream_.refuse();
    }
    std::vector<btPersistentManifold*> order;
    for (int i = 0; i < count && stream_.good(); ++i) {
        btPersistentManifold* manifold = dispatcher_.getManifoldByIndexInternal(i);
        Place place = stream_.reads() ? Place{} : places[manifold];
        stream_(place.pair, place.number);
        if (place.pair < 0 || place.pair >= pairs.size() || place.number < 0 ||
            place.number >= by_pair[static_cast<size_t>(place.pair)].size()) {
            return stream_.refuse();
        }
        manifold = by_pair[static_cast<size_t>(place.pair)][place.number];
        serialize_points(*manifold);
        order.push_back(manifold);
    }
    if (!stream_.reads() || !stream_.good()) return;
    std::vector<btPersistentManifold*> sorted = order;
    std::sort(sorted.begin(), sorted.end());
    if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end()) return stream_.refuse();
    for (int i = 0; i < count; ++i) {
        dispatcher_.getInternalManifoldPointer()[i] = order[static_cast<size_t>(i)];
        order[static_cast<size_t>(i)]->m_index1a = i;
    }
}

}  // namespace

Status check_contacts(btDiscreteDynamicsWorld& world) {
    if (!dynamic_cast<btDbvtBroadphase*>(world.getBroadphase())) {
        return Error{"the world's broadphase must be a btDbvtBroadphase"};
    }
    if (!dynamic_cast<btCollisionDispatcher*>(world.getDispatcher())) {
        return Error{"the world's dispatcher must be a btCollisionDispatcher"};
    }
    const auto& broadphase = *static_cast<btDbvtBroadphase*>(world.getBroadphase());
    if (broadphase.m_sets[0].m_leaves + broadphase.m_sets[1].m_leaves !=
        world.getNumCollisionObjects()) {
        return Error{"the broadphase must hold the world's objects and nothing else"};
    }
    return Done{};
}

void serialize_contacts(StateStream& stream, btDiscreteDynamicsWorld& world) {
    ContactCache(stream, world).serialize();
}

}  // namespace bsoil::bullet

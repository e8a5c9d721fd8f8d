#include <algorithm>
#include <set>
#include <span>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/loop/map_extensions.hpp>
#include <chasles/loop/map_family.hpp>

namespace chasles {
namespace {

struct Member {
  MapPart part;
  std::set<int> files;
  int parent = -1;  // that it extends
};

// A total order of maps that may be merged: no two have a session that begins alike, but extensions
// after what they extend.
bool before(const Member& x, const Member& y) {
  const auto key = [](const MapSession& session) { return std::tie(session.begin, session.name); };
  return std::ranges::lexicographical_compare(
      x.part.map.sessions, y.part.map.sessions,
      [&](const MapSession& a, const MapSession& b) { return key(a) < key(b); });
}

// Each once, with all files that have it.
std::vector<Member> each_once(std::vector<MapPart> parts) {
  std::vector<Member> once;
  for (MapPart& part : parts) {
    const auto known = std::ranges::find_if(
        once, [&](const Member& other) { return is_same_map(part.map, other.part.map); });
    const bool fresh = known == once.end();
    Member& member = fresh ? once.emplace_back() : *known;
    if (part.file >= 0) member.files.insert(part.file);
    if (fresh) member.part = std::move(part);
  }
  return once;
}

bool meet(const std::set<int>& a, const std::set<int>& b) {
  return std::ranges::any_of(a, [&](int file) { return b.contains(file); });
}

// Parts that are in one file, and those that are in one file with these.
void connect_files(std::vector<Member>& members) {
  for (bool changed = true; changed;) {
    changed = false;
    for (Member& a : members) {
      for (const Member& b : members) {
        if (!meet(a.files, b.files) || a.files == b.files) continue;
        const std::size_t count = a.files.size();
        a.files.insert(b.files.begin(), b.files.end());
        changed = changed || a.files.size() > count;
      }
    }
  }
}

// What has most sessions of those that it extends.
void find_parents(std::vector<Member>& members) {
  for (Member& member : members) {
    std::size_t most = 0;
    for (std::size_t k = 0; k < members.size(); ++k) {
      const LandmarkMap& base = members[k].part.map;
      if (base.sessions.size() <= most || !meet(members[k].files, member.files) ||
          !extends(member.part.map, base)) {
        continue;
      }
      most = base.sessions.size();
      member.parent = static_cast<int>(k);
    }
  }
}

std::vector<int> ancestors(const std::vector<Member>& members, int member) {
  std::vector<int> all;
  for (; member >= 0; member = members[static_cast<std::size_t>(member)].parent) {
    all.push_back(member);
  }
  return all;
}

// The number of sessions that two have from a common ancestor, which may be one of them.
std::size_t common_sessions(const std::vector<Member>& members, int a, int b) {
  const std::vector<int> of_a = ancestors(members, a), of_b = ancestors(members, b);
  for (const int ancestor : of_a) {
    if (std::ranges::find(of_b, ancestor) == of_b.end()) continue;
    return members[static_cast<std::size_t>(ancestor)].part.map.sessions.size();
  }
  return 0;
}

void check_sessions(const MapPart& a, const MapPart& b, std::size_t common) {
  for (const MapSession& x : std::span(a.map.sessions).subspan(common)) {
    for (const MapSession& y : std::span(b.map.sessions).subspan(common)) {
      if (x.name == y.name && x.begin <= y.end && y.begin <= x.end) {
        throw InputError(fmt::format(
            "{} and {}: different maps with a session of the recording {}: merging them would "
            "count it twice; leave one of them out, or extend one by a run in it instead (chasles "
            "run --map MAP --extend)",
            a.name, b.name, x.name));
      }
    }
  }
}

void check_sessions(const std::vector<Member>& members) {
  for (std::size_t i = 0; i < members.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      check_sessions(members[k].part, members[i].part,
                     common_sessions(members, static_cast<int>(k), static_cast<int>(i)));
    }
  }
}

std::vector<int> children(const std::vector<Member>& members, int parent) {
  std::vector<int> all;
  for (std::size_t i = 0; i < members.size(); ++i) {
    if (members[i].parent == parent) all.push_back(static_cast<int>(i));
  }
  return all;
}

// The member with what the others contribute to it. `kept` receives whose maps that takes.
MapPart joined_family(const std::vector<Member>& members, int member, std::vector<bool>& kept) {
  const MapPart& part = members[static_cast<std::size_t>(member)].part;
  std::vector<MapPart> extensions;
  for (const int child : children(members, member)) {
    extensions.push_back(joined_family(members, child, kept));
  }
  if (extensions.size() != 1) kept[static_cast<std::size_t>(member)] = true;
  if (extensions.empty()) return part;
  if (extensions.size() == 1) return extensions.front();
  return {.name = part.name, .map = joined_extensions(part.map, extensions)};
}

}  // namespace

bool is_same_map(const LandmarkMap& x, const LandmarkMap& y) {
  const auto same_session = [](const MapSession& a, const MapSession& b) {
    return a.name == b.name && a.begin == b.begin && a.end == b.end;
  };
  const auto same_point = [](const MapPoint& a, const MapPoint& b) {
    return a.p_map == b.p_map && a.session == b.session && a.observations == b.observations;
  };
  return std::ranges::equal(x.sessions, y.sessions, same_session) &&
         std::ranges::equal(x.points, y.points, same_point) &&
         x.covariance.own() == y.covariance.own() && x.covariance.rank() == y.covariance.rank() &&
         x.covariance.shared() == y.covariance.shared();
}

MapFamilies map_families(std::vector<MapPart> parts) {
  std::vector<Member> members = each_once(std::move(parts));
  connect_files(members);
  find_parents(members);
  check_sessions(members);
  std::ranges::sort(members, before);
  for (Member& member : members) member.parent = -1;
  find_parents(members);
  MapFamilies families;
  std::vector<bool> kept(members.size());
  for (const int root : children(members, -1)) {
    families.joined.push_back(joined_family(members, root, kept));
  }
  for (std::size_t i = 0; i < members.size(); ++i) {
    if (kept[i]) families.parts.push_back(std::move(members[i].part.map));
  }
  return families;
}

}  // namespace chasles

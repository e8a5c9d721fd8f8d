#pragma once

#include <functional>

#include <chasles/foxglove/channel.hpp>
#include <chasles/live/comparison.hpp>

namespace chasles {

/// /ways of a run in progress: the estimated path in pieces, of which only the last one grows and
/// is sent again; dead reckoning and the true path once. Late subscribers get all of it.
class WayChannel final : public FoxgloveChannel {
 public:
  static constexpr std::size_t kPiece = 500;  ///< states of a piece

  /// `comparison` is that of the run's states. Both must outlive the channel.
  WayChannel(const ProtoSchemas& schemas, const Run& run, const GrowingComparison& comparison);

  /// Shows the states that there are by now.
  void show() { shown_ = run_.states.size(); }

  std::optional<Time> due(const ChannelCursor& cursor) const override;
  std::optional<std::string> take(ChannelCursor& cursor) override;

 private:
  nlohmann::json beginning() const;
  nlohmann::json piece(std::size_t from, std::size_t to) const;
  bool owes_truth(const ChannelCursor& cursor) const;
  /// The end of the piece that begins or goes on at this state.
  std::size_t end_of(std::size_t state) const;

  const Run& run_;
  const GrowingComparison& comparison_;
  std::size_t shown_ = 0;  ///< number of states
};

}  // namespace chasles

"""How each metric is defined, for the page of metrics; ``tests/test_reference_pages.py`` holds both together.

Sums and means are over the samples of one robot in one run, T is the time that it was in play.
"""

UNDER_WAY = "from 6 s (of a short run, from half its time)"
FORMULAS = {
    "mean_abs_x_error_m": "mean of |x_err|, the error along the robot's heading (5.9)",
    "mean_abs_y_error_m": "mean of |y_err|, the error across the robot's heading (5.9)",
    "mean_abs_heading_error_rad": "mean of |ψ_err|, ψ_err wrapped to (−π, π]",
    "mean_error_norm": "mean of √(x_err² + y_err² + ψ_err²)",
    "mean_speed_error_mps": "mean of |v_demand − v|",
    "rms_cross_track_m": "√(mean of c²), c the signed distance to the nearest point of the path, "
    "past its end beside the tangent there",
    "overshoot_m": "max of the way past the path's end, along the tangent there; 0: never past it",
    "rms_cross_track_under_way_m": f"√(mean of c²) {UNDER_WAY} while the reference moves; infinite if stopped before",
    "max_cross_track_m": "max |c|",
    "settling_time_s": "the first time after which √(x_err² + y_err²) < 5 cm to the end; infinite: never",
    "path_settling_time_s": "the first time after which |c| < 5 cm to the end; infinite: never",
    "final_error_m": "√(x_err² + y_err²) at the last known sample",
    "control_effort": "∫ (τ_right² + τ_left²) dt / T",
    "torque_variation_nmps": "(Σ |Δτ_right| + |Δτ_left|) / T",
    "v_variation_mps2": "Σ |Δv_demand| / T",
    "rms_distance_late_m": f"√(mean of x_err² + y_err²) {UNDER_WAY} to the end; infinite if stopped before",
    "rms_heading_late_rad": f"√(mean of ψ_err²) {UNDER_WAY} to the end; infinite if stopped before",
    "w_variation_late_radps2": f"Σ |Δω_demand| {UNDER_WAY} to the end, divided by that time",
    "w_variation_radps2": "Σ |Δω_demand| / T",
    "alignment_time_s": "the first time after which |x_leader − mean of the followers' x| < 10 cm to the leader's end; "
    "where x does not grow along all paths, along the leader's path",
    "final_spread_m": "max x_i − min x_i at the leader's end; where x does not grow, along the leader's path",
    "max_lateral_error_m": "max |c| to the leader's end",
    "max_place_error_m": "max of p, the distance from the point of the own path level with the leader, from 10 s on "
    "to the leader's end",
    "rms_place_error_m": "√(mean of p²) over the same time",
    "arrival_time_s": "the first time with 99.5 % of the path behind it, along the tangent at its end, at most 10 cm "
    "beside and beyond that; infinite: never",
    "arrival_spread_s": "max − min of the robots' arrival times",
    "max_progress_gap": "max of max s_i − min s_i, s_i the share of the path truly behind robot i",
    "mean_progress_gap": "mean of max s_i − min s_i",
    "min_distance_m": "min over time and other robots of √((x_i − x_j)² + (y_i − y_j)²)",
    "contacts": "how often the robot's rectangle begins to touch another's or an obstacle, between samples too",
    "min_clearance_m": "the least distance of the robot's rectangle to another's or an obstacle; below 0, how deep",
    "emergency_share": "the periods in which the emergency rule overrode the law, divided by those until arrival",
    "goal_reached": "1 if it is at the goal for as long as `hold` says without a break, else 0",
    "goal_time_s": "when the first such stay begins; at the goal: within `within` of it or in its region, and within "
    "`heading_within` of its heading if it has one",
    "goal_error_m": "distance of the robot's center from the goal, or from its region, at the last sample",
    "goal_heading_error_rad": "|ψ_err| at the last sample; 0 where any heading will do",
    "goal_share": "samples at the goal from goal_time_s on, divided by all from then on; 0: never reached",
}

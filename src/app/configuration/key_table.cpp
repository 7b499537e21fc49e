#include <array>
#include <iomanip>
#include <sstream>
#include <type_traits>

#include "servohil/app/configuration.hpp"

namespace servohil::app {
namespace {

using C = Configuration;

// Ranges: what the equations and their solution hold for with room to spare, not what is sensible.
constexpr std::array kKeys = std::to_array<Key>({
    {"model.physics", "", 0.0, 0.0, "\"full\": over the whole envelope; \"thesis\": the source to the letter",
     +[](C& c) -> model::Physics& { return c.model.physics; }},
    {"oil.name", "", 0.0, 0.0,
     "\"custom\" (density, viscosity below), \"mil_h_5606\" or \"iso_vg_32\" (at the temperature below)",
     +[](C& c) -> model::OilName& { return c.model.oil.name; }},
    {"oil.temperature_c", "°C", -20.0, 120.0, "temperature of a named oil",
     +[](C& c) -> double& { return c.model.oil.temperature_c; }},
    {"oil.density_lbf_s2_in4", "lbf s²/in⁴", 1e-5, 2e-4, "rho, oil density (Table II)",
     +[](C& c) -> double& { return c.model.oil.density_lbf_s2_in4; }},
    {"oil.viscosity_lbf_s_in2", "lbf s/in²", 1e-8, 1e-3, "mu, absolute viscosity (Table II)",
     +[](C& c) -> double& { return c.model.oil.viscosity_lbf_s_in2; }},
    {"oil.air_fraction", "", 0.0, 0.2,
     "r, free air per liquid, both volumes at atmospheric pressure (MODEL.md)",
     +[](C& c) -> double& { return c.model.oil.air_fraction; }},
    {"oil.air_polytropic_index", "", 1.0, 1.4, "n: 1 isothermal, 1.4 adiabatic",
     +[](C& c) -> double& { return c.model.oil.air_polytropic_index; }},
    {"oil.dissolution_pressure_psi", "psi absolute", 0.0, 5000.0,
     "all air is dissolved from here on; 0: none ever, else above 20",
     +[](C& c) -> double& { return c.model.oil.dissolution_pressure_psi; }},
    {"oil.vapour_pressure_psi", "psi absolute", 0.0, 10.0, "no chamber falls below it",
     +[](C& c) -> double& { return c.model.oil.vapour_pressure_psi; }},
    {"orifice.transition_pressure_psi", "psi", 1e-3, 10.0, "p_t: orifices are laminar below, turbulent above",
     +[](C& c) -> double& { return c.model.orifice.transition_pressure_psi; }},

    {"servo.relay_piston_rod_diameter_in", "in", 0.0, 10.0, "d1 (Table II)",
     +[](C& c) -> double& { return c.model.servo.relay_piston_rod_diameter_in; }},
    {"servo.relay_piston_diameter_in", "in", 0.1, 10.0, "d2 (Table II)",
     +[](C& c) -> double& { return c.model.servo.relay_piston_diameter_in; }},
    {"servo.piston_diameter_in", "in", 1.0, 50.0, "d3, servomotor piston (Table II)",
     +[](C& c) -> double& { return c.model.servo.piston_diameter_in; }},
    {"servo.capillary_diameter_in", "in", 0.001, 1.0, "d4, capillary through the relay plunger (Table II)",
     +[](C& c) -> double& { return c.model.servo.capillary_diameter_in; }},
    {"servo.relay_plunger_diameter_in", "in", 0.1, 20.0, "d6 (Table II)",
     +[](C& c) -> double& { return c.model.servo.relay_plunger_diameter_in; }},
    {"servo.relay_port_width_in", "in", 0.01, 20.0, "w1, ports in the relay piston stem (Table II)",
     +[](C& c) -> double& { return c.model.servo.relay_port_width_in; }},
    {"servo.relay_plunger_area_in2", "in²", 0.1, 100.0, "A2, area above the relay plunger (Appendix A)",
     +[](C& c) -> double& { return c.model.servo.relay_plunger_area_in2; }},
    {"servo.relay_piston_clearance_in", "in", 0.0, 0.02, "c_r1, radial (Table II)",
     +[](C& c) -> double& { return c.model.servo.relay_piston_clearance_in; }},
    {"servo.relay_plunger_clearance_in", "in", 0.0, 0.02, "c_r2, radial (Table II)",
     +[](C& c) -> double& { return c.model.servo.relay_plunger_clearance_in; }},
    {"servo.piston_clearance_in", "in", 1e-5, 0.05, "c_r3, on diameter (Appendix E)",
     +[](C& c) -> double& { return c.model.servo.piston_clearance_in; }},
    {"servo.piston_leakage_length_in", "in", 0.01, 20.0, "L3, leakage path past the piston (Table II)",
     +[](C& c) -> double& { return c.model.servo.piston_leakage_length_in; }},
    {"servo.capillary_length_in", "in", 0.01, 100.0, "L4 (Table II)",
     +[](C& c) -> double& { return c.model.servo.capillary_length_in; }},
    {"servo.pilot_spring_rate_lbf_in", "lbf/in", 0.1, 1e4, "k1, spring (11) (Table II)",
     +[](C& c) -> double& { return c.model.servo.pilot_spring_rate_lbf_in; }},
    {"servo.main_spring_rate_lbf_in", "lbf/in", 0.1, 1e5, "k2, spring (10) (Table II)",
     +[](C& c) -> double& { return c.model.servo.main_spring_rate_lbf_in; }},
    {"servo.main_spring_preload_lbf", "lbf", 0.0, 1e4, "F_s (Table II)",
     +[](C& c) -> double& { return c.model.servo.main_spring_preload_lbf; }},
    {"servo.underlap_in", "in", -0.05, 0.05,
     "U, underlap of the metering ports; negative: overlap (Table II)",
     +[](C& c) -> double& { return c.model.servo.underlap_in; }},
    {"servo.piston_mass_lbf_s2_in", "lbf s²/in", 0.001, 100.0, "m3, piston and rod (Table II)",
     +[](C& c) -> double& { return c.model.servo.piston_mass_lbf_s2_in; }},
    {"servo.load_mass_lbf_s2_in", "lbf s²/in", 0.0, 1000.0, "m_e, lever and valves at the piston (Table II)",
     +[](C& c) -> double& { return c.model.servo.load_mass_lbf_s2_in; }},
    {"servo.relay_volume_in3", "in³", 0.01, 1000.0, "V4, oil above the relay plunger (Table II)",
     +[](C& c) -> double& { return c.model.servo.relay_volume_in3; }},
    {"servo.piston_volume_at_zero_in3", "in³", 0.1, 10000.0, "V3 at x3 = 0 (Appendix A)",
     +[](C& c) -> double& { return c.model.servo.piston_volume_at_zero_in3; }},
    {"servo.bulk_modulus_psi", "psi", 1000.0, 500000.0, "beta, oil and entrained air together (Table II)",
     +[](C& c) -> double& { return c.model.servo.bulk_modulus_psi; }},
    {"servo.discharge_coefficient", "", 0.1, 1.0, "c_d, of every orifice (Table II)",
     +[](C& c) -> double& { return c.model.servo.discharge_coefficient; }},
    {"servo.stroke_in", "in", 0.1, 100.0, "largest x3 (Figure 3)",
     +[](C& c) -> double& { return c.model.servo.stroke_in; }},
    {"servo.relay_port_height_in", "in", 0.01, 10.0, "largest opening of orifice 5 (assumed)",
     +[](C& c) -> double& { return c.model.servo.relay_port_height_in; }},
    {"servo.metering_port_height_in", "in", 0.01, 10.0, "largest opening of orifices 3 and 6 (assumed)",
     +[](C& c) -> double& { return c.model.servo.metering_port_height_in; }},
    {"servo.relay_piston_stroke_in", "in", 0.1, 100.0, "largest x1 (assumed)",
     +[](C& c) -> double& { return c.model.servo.relay_piston_stroke_in; }},
    {"servo.relay_plunger_travel_in", "in", 0.01, 10.0, "largest |x2 - x4| (assumed)",
     +[](C& c) -> double& { return c.model.servo.relay_plunger_travel_in; }},

    {"supply.pressure_psi", "psi", 1.0, 5000.0, "P2 (Appendix E)",
     +[](C& c) -> double& { return c.model.supply.pressure_psi; }},
    {"supply.drain_pressure_psi", "psi", 0.0, 100.0, "Pe, back pressure of the drain",
     +[](C& c) -> double& { return c.model.supply.drain_pressure_psi; }},
    {"supply.pump_flow_in3_s", "in³/s", 0.0, 100000.0,
     "largest pump flow; 0: P2 is constant whatever is drawn",
     +[](C& c) -> double& { return c.model.supply.pump_flow_in3_s; }},
    {"supply.pump_band_psi", "psi", 0.1, 1000.0, "below the set point: the pump goes from none to all",
     +[](C& c) -> double& { return c.model.supply.pump_band_psi; }},
    {"supply.accumulator_volume_in3", "in³", 1.0, 1e6, "gas in the accumulator at the set point",
     +[](C& c) -> double& { return c.model.supply.accumulator_volume_in3; }},

    {"cam.shape", "", 0.0, 0.0, "\"single\" or \"two_slope\" (Figure 4, curve B or A)",
     +[](C& c) -> model::CamShape& { return c.model.cam.shape; }},
    {"cam.alpha", "", 0.01, 10.0, "single slope: alpha (Appendix A)",
     +[](C& c) -> double& { return c.model.cam.alpha; }},
    {"cam.x3_star_in", "in", -20.0, 20.0, "single slope: x3*, x4 at x3 = 0 (Appendix A)",
     +[](C& c) -> double& { return c.model.cam.x3_star_in; }},
    {"cam.lower_alpha", "", 0.01, 10.0, "two slopes: alpha below the knee (Appendix A)",
     +[](C& c) -> double& { return c.model.cam.lower_alpha; }},
    {"cam.lower_x3_star_in", "in", -20.0, 20.0, "two slopes: x3* below the knee (Appendix A)",
     +[](C& c) -> double& { return c.model.cam.lower_x3_star_in; }},
    {"cam.upper_alpha", "", 0.01, 10.0, "two slopes: alpha above the knee (Appendix A)",
     +[](C& c) -> double& { return c.model.cam.upper_alpha; }},
    {"cam.upper_x3_star_in", "in", -20.0, 20.0, "two slopes: x3* above the knee (Appendix A)",
     +[](C& c) -> double& { return c.model.cam.upper_x3_star_in; }},

    {"friction.coulomb_psi", "psi", 0.0, 200.0, "B, Coulomb friction as a pressure under the piston (4.4)",
     +[](C& c) -> double& { return c.model.friction.coulomb_psi; }},
    {"friction.breakaway_psi", "psi", 0.0, 400.0, "B_s, from rest; 0: as B",
     +[](C& c) -> double& { return c.model.friction.breakaway_psi; }},
    {"friction.stribeck_velocity_in_s", "in/s", 1e-3, 100.0, "v_s, at which half of B_s - B is gone",
     +[](C& c) -> double& { return c.model.friction.stribeck_velocity_in_s; }},
    {"friction.viscous_psi_s_in", "psi s/in", 0.0, 100.0, "B_v, viscous friction",
     +[](C& c) -> double& { return c.model.friction.viscous_psi_s_in; }},
    {"friction.closing_ratio", "", 0.1, 10.0, "friction downward to friction upward",
     +[](C& c) -> double& { return c.model.friction.closing_ratio; }},

    {"stabilizer.enabled", "", 0.0, 0.0, "transient flow stabilizer connected (chapter V)",
     +[](C& c) -> bool& { return c.model.stabilizer.enabled; }},
    {"stabilizer.capillary_diameter_in", "in", 0.001, 2.0, "d7 (Table VII)",
     +[](C& c) -> double& { return c.model.stabilizer.capillary_diameter_in; }},
    {"stabilizer.capillary_length_in", "in", 0.1, 1000.0, "L7 (Table VII)",
     +[](C& c) -> double& { return c.model.stabilizer.capillary_length_in; }},
    {"stabilizer.oil_volume_in3", "in³", 0.0, 10000.0, "V8 (Table VII)",
     +[](C& c) -> double& { return c.model.stabilizer.oil_volume_in3; }},
    {"stabilizer.gas_volume_in3", "in³", 0.1, 10000.0, "V_a (Table VII)",
     +[](C& c) -> double& { return c.model.stabilizer.gas_volume_in3; }},
    {"stabilizer.polytropic_index", "", 1.0, 2.0, "k, 1.4 adiabatic, 1 isothermal (5.5)",
     +[](C& c) -> double& { return c.model.stabilizer.polytropic_index; }},
    {"stabilizer.charge_pressure_psi", "psi", 0.0, 5000.0, "at which the gas has V_a",
     +[](C& c) -> double& { return c.model.stabilizer.charge_pressure_psi; }},
    {"stabilizer.precharge_psi", "psi", 0.0, 5000.0, "below it the diaphragm rests on its seat",
     +[](C& c) -> double& { return c.model.stabilizer.precharge_psi; }},

    {"load.file", "", 0.0, 0.0, "CSV file x3_in,p3_psi: the load at rest (Figure 3)",
     +[](C& c) -> std::string& { return c.load_file; }},
    {"load.closing_file", "", 0.0, 0.0, "CSV file for downward motion; \"\": as load.file",
     +[](C& c) -> std::string& { return c.load_closing_file; }},
    {"load.beyond", "", 0.0, 0.0,
     "beyond the table: \"extrapolate\" its end segments or \"hold\" its end values",
     +[](C& c) -> model::LoadBeyond& { return c.model.load.beyond; }},

    {"start.x3_in", "in", 0.0, 100.0, "piston position at rest until the first command",
     +[](C& c) -> double& { return c.start_x3_in; }},

    {"loop.wake_ticks", "ticks", 1.0, 1000.0, "ticks of 0.1 ms per wake-up of the loop",
     +[](C& c) -> int& { return c.loop.wake_ticks; }},
    {"loop.priority", "", 11.0, 99.0, "SCHED_FIFO priority of the loop (the bus threads: 5 and 10 below)",
     +[](C& c) -> int& { return c.loop.priority; }},
    {"loop.cpu", "", -1.0, 1023.0, "CPU of the loop; -1: any", +[](C& c) -> int& { return c.loop.cpu; }},
    {"loop.overrun", "", 0.0, 0.0,
     "when more is to be caught up than the limit below: \"catch_up\" all of it, \"freeze\" or \"stop\"",
     +[](C& c) -> Overrun& { return c.loop.overrun; }},
    {"loop.max_catch_up_ticks", "ticks", 0.0, 1e6,
     "late ticks that run back to back before loop.overrun acts",
     +[](C& c) -> int& { return c.loop.max_catch_up_ticks; }},
    {"loop.grace_ms", "ms", 0.0, 60'000.0,
     "after the start: ticks may be late without making the run invalid",
     +[](C& c) -> int& { return c.loop.grace_ms; }},

    {"lockstep.ticks", "ticks", 1.0, 100'000.0,
     "--clock lockstep: ticks of 0.1 ms per frame that lets time pass",
     +[](C& c) -> int& { return c.lockstep.ticks; }},
    {"lockstep.sync_id", "", -1.0, 2047.0,
     "standard identifier of the frame that lets time pass; -1: the command frame",
     +[](C& c) -> int& { return c.lockstep.sync_id; }},

    {"fault.armed", "", 0.0, 0.0,
     "whether faults may be injected: \"yes\", \"no\", \"auto\": where no bus is physical",
     +[](C& c) -> Armed& { return c.fault.armed; }},
    {"fault.allow_can", "", 0.0, 0.0,
     "FAULT_Request frames inject and clear faults, where fault.armed allows any (PROTOCOL.md)",
     +[](C& c) -> bool& { return c.fault.allow_can; }},

    {"safety.timeout_ms", "ms", -1.0, 60'000.0,
     "without a valid command; then safety.on_loss; 0: never; -1: three times can.command.cycle_ms",
     +[](C& c) -> int& { return c.safety.timeout_ms; }},
    {"safety.on_loss", "", 0.0, 0.0,
     "lost or not enabled: \"drain\" (P1 falls to 0), \"hold\" (P1 stays) or \"freeze\" (the state stays)",
     +[](C& c) -> OnLoss& { return c.safety.on_loss; }},
    {"safety.drain_time_constant_s", "s", 0.0, 60.0, "of P1 when the command is lost; 0: at once",
     +[](C& c) -> double& { return c.safety.drain_time_constant_s; }},
    {"safety.trip_time_constant_s", "s", 0.0, 60.0, "of P1 after a trip; 0: at once",
     +[](C& c) -> double& { return c.safety.trip_time_constant_s; }},
    {"safety.recover_after", "frames", 1.0, 1000.0,
     "valid ones in a row, until the command is followed again",
     +[](C& c) -> int& { return c.safety.recover_after; }},
    {"safety.max_age_ms", "ms", 0.0, 60'000.0, "of a command frame when it is read, else discarded; 0: any",
     +[](C& c) -> int& { return c.safety.max_age_ms; }},
    {"safety.p1_minimum_psi", "psi", 0.0, 1000.0, "below it a command frame is not valid",
     +[](C& c) -> double& { return c.safety.p1_minimum_psi; }},
    {"safety.p1_maximum_psi", "psi", 0.0, 1000.0, "above it a command frame is not valid",
     +[](C& c) -> double& { return c.safety.p1_maximum_psi; }},
    {"safety.p1_rate_psi_s", "psi/s", 0.0, 1e6,
     "faster a command frame is not valid, over at least one cycle time; 0: any",
     +[](C& c) -> double& { return c.safety.p1_rate_psi_s; }},

    {"can.dbc", "", 0.0, 0.0, "DBC file or list of them: the contract with the governor",
     +[](C& c) -> std::vector<std::string>& { return c.can.dbc; }},
    {"can.buses", "", 0.0, 0.0, "bus URLs; \"auto\": the first of can.interfaces, else slcan:pty",
     +[](C& c) -> std::vector<std::string>& { return c.can.buses; }},
    {"can.interfaces", "", 0.0, 0.0, "kernel interfaces that \"auto\" looks for, in this order",
     +[](C& c) -> std::vector<std::string>& { return c.can.interfaces; }},
    {"can.bit_rate_bit_s", "bit/s", 10000.0, 1000000.0, "nominal bit rate of the bus",
     +[](C& c) -> int& { return c.can.bit_rate_bit_s; }},
    {"can.data_bit_rate_bit_s", "bit/s", 10000.0, 8000000.0, "of CAN FD frames with bit-rate switch",
     +[](C& c) -> int& { return c.can.data_bit_rate_bit_s; }},
    {"can.allow_physical", "", 0.0, 0.0,
     "whether a bus may be used that is neither vcan nor a pseudo-terminal",
     +[](C& c) -> bool& { return c.can.allow_physical; }},
    {"can.configure", "", 0.0, 0.0,
     "sets up kernel interfaces at the start, by the bit rate and the three below",
     +[](C& c) -> bool& { return c.can.configure; }},
    {"can.sample_point", "", 0.0, 0.999, "sample point, share of a bit; 0: the kernel's choice",
     +[](C& c) -> double& { return c.can.sample_point; }},
    {"can.restart_ms", "ms", 0.0, 100000.0,
     "after bus-off the kernel restarts the controller; 0: servohil does, by the back-off",
     +[](C& c) -> int& { return c.can.restart_ms; }},
    {"can.queue_length", "frames", 1.0, 1000.0, "transmit queue",
     +[](C& c) -> int& { return c.can.queue_length; }},
    {"can.backoff_ms", "ms", 10.0, 100000.0,
     "first restart after bus-off where the kernel does not; doubled each time",
     +[](C& c) -> int& { return c.can.backoff_ms; }},
    {"can.most_backoff_ms", "ms", 10.0, 1000000.0, "longest wait for a restart",
     +[](C& c) -> int& { return c.can.most_backoff_ms; }},
    {"can.emulate_bitrate", "bit/s", 0.0, 1000000.0,
     "frames take their time and turn as on a real bus of this bit rate, virtual buses only; 0: they do not",
     +[](C& c) -> int& { return c.can.emulate_bit_rate_bit_s; }},

    {"can.command.p1", "", 0.0, 0.0, "MESSAGE.SIGNAL of the DBC that carries P1",
     +[](C& c) -> std::string& { return c.can.command.p1; }},
    {"can.command.unit", "", 0.0, 0.0, "its unit (psi, bar, kPa, ...); empty: as the DBC says",
     +[](C& c) -> std::string& { return c.can.command.unit; }},
    {"can.command.scale", "", 0.0, 0.0, "instead: two points, its value and psi: [[4.0, 0.0], [20.0, 150.0]]",
     +[](C& c) -> Scale& { return c.can.command.scale; }},
    {"can.command.may_clip", "", 0.0, 0.0, "the signal need not reach from closed to open",
     +[](C& c) -> bool& { return c.can.command.may_clip; }},
    {"can.command.enable", "", 0.0, 0.0,
     "MESSAGE.SIGNAL, enabled unless 0, or MESSAGE.SIGNAL = VALUE; empty: always",
     +[](C& c) -> std::string& { return c.can.command.enable; }},
    {"can.command.trip", "", 0.0, 0.0,
     "MESSAGE.SIGNAL, tripped unless 0, or MESSAGE.SIGNAL = VALUE; empty: never",
     +[](C& c) -> std::string& { return c.can.command.trip; }},
    {"can.command.pgn", "", 0.0, 0.0, "J1939: the parameter group counts, not source address and priority",
     +[](C& c) -> bool& { return c.can.command.pgn; }},
    {"can.command.cycle_ms", "ms", 1.0, 10000.0, "expected cycle time of the command",
     +[](C& c) -> int& { return c.can.command.cycle_ms; }},
    {"can.command.e2e", "", 0.0, 0.0,
     "protection: \"none\", \"counter\", \"crc8_j1850\", \"autosar_p1\", \"autosar_p11\", "
     "\"j1939_counter_checksum\"",
     +[](C& c) -> can::E2eProfile& { return c.can.command.protection.profile; }},
    {"can.command.data_id", "", -1.0, 65535.0, "Data ID of the protection; -1: none",
     +[](C& c) -> int& { return c.can.command.protection.data_id; }},
    {"can.command.data_id_mode", "", 0.0, 0.0,
     "what of it is in the CRC: \"both\" bytes, \"alt\", \"low\" or \"nibble\"",
     +[](C& c) -> can::DataIdMode& { return c.can.command.protection.data_id_mode; }},
    {"can.command.counter", "", 0.0, 0.0, "signal of the counter; empty: where the profile has it",
     +[](C& c) -> std::string& { return c.can.command.protection.counter; }},
    {"can.command.checksum", "", 0.0, 0.0, "signal of the checksum; empty: where the profile has it",
     +[](C& c) -> std::string& { return c.can.command.protection.checksum; }},
    {"can.command.max_counter_jump", "", 1.0, 127.0,
     "largest step of the counter that is valid; 1: no frame may be lost",
     +[](C& c) -> int& { return c.can.command.max_counter_jump; }},

    {"publish.position_ms", "ms", 0.0, 10000.0, "cycle time of SERVO_Position; 0: not sent",
     +[](C& c) -> int& { return c.publish.position_ms; }},
    {"publish.pressures_ms", "ms", 0.0, 10000.0, "cycle time of SERVO_Pressures; 0: not sent",
     +[](C& c) -> int& { return c.publish.pressures_ms; }},
    {"publish.relay_ms", "ms", 0.0, 10000.0, "cycle time of SERVO_Relay; 0: not sent",
     +[](C& c) -> int& { return c.publish.relay_ms; }},
    {"publish.status_ms", "ms", 0.0, 10000.0, "cycle time of SERVO_Status; 0: not sent",
     +[](C& c) -> int& { return c.publish.status_ms; }},
    {"publish.safety_ms", "ms", 0.0, 10000.0, "cycle time of SERVO_Safety; 0: not sent",
     +[](C& c) -> int& { return c.publish.safety_ms; }},
    {"publish.bus_ms", "ms", 0.0, 10000.0, "cycle time of SERVO_Bus, sent on each change, too; 0: not sent",
     +[](C& c) -> int& { return c.publish.bus_ms; }},
});

/// A value as it would stand in the file.
struct ShownDefault {
  std::string operator()(double v) const {
    std::ostringstream out;
    out << v;
    return out.str();
  }
  std::string operator()(int v) const { return std::to_string(v); }
  std::string operator()(bool v) const { return v ? "true" : "false"; }
  std::string operator()(const std::string& v) const { return '"' + v + '"'; }
  std::string operator()(const std::vector<std::string>& v) const {
    std::string text = "[";
    for (const std::string& item : v) text += (text.size() > 1 ? ", \"" : "\"") + item + '"';
    return text + "]";
  }
  std::string operator()(const Scale& v) const {
    std::string text = "[";
    for (const ScalePoint& p : v)
      text += (text.size() > 1 ? ", [" : "[") + (*this)(p.from) + ", " + (*this)(p.to) + "]";
    return text + "]";
  }
  template <typename Enum>
  requires std::is_enum_v<Enum> std::string operator()(Enum v) const {
    return std::string("\"") + NamesOf(v)[static_cast<std::size_t>(v)] + '"';
  }
};

}  // namespace

std::span<const Key> KeyTable() {
  return kKeys;
}

std::string DescribeKeys() {
  Configuration defaults;
  std::ostringstream out;
  for (const Key& key : kKeys) {
    const std::string value =
        std::visit([&](auto place) { return ShownDefault{}(place(defaults)); }, key.place);
    out << "  " << key.name << " = " << value << (*key.unit != 0 ? " " : "") << key.unit;
    if (key.minimum < key.maximum) out << "  [" << key.minimum << " to " << key.maximum << "]";
    out << "\n      " << key.meaning << '\n';
  }
  return out.str();
}

}  // namespace servohil::app

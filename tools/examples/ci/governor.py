"""The governor under test: your code in place of this one."""


class Governor:
    """Position governor: P1 by proportional and integral action on the piston's position, every 10 ms."""

    CYCLE_S = 0.01
    LOW_PSI, HIGH_PSI = 20.0, 60.0

    def __init__(self, rest_psi, gain_psi_in=0.5, integral_psi_in_s=20.0):
        self._gain, self._integral = gain_psi_in, integral_psi_in_s
        self._sum_psi = rest_psi
        self.p1_psi = rest_psi  # the newest command, gauge

    def cycle(self, set_point_in, x3_in):
        """The next command, for the position wanted and the position measured [in]."""
        error_in = set_point_in - x3_in
        wanted_psi = self._sum_psi + self._gain * error_in
        self.p1_psi = min(max(wanted_psi, self.LOW_PSI), self.HIGH_PSI)
        if self.p1_psi == wanted_psi:  # else the sum would run away
            self._sum_psi += self._integral * error_in * self.CYCLE_S
        return self.p1_psi

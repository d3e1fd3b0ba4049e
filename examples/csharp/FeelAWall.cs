// Pushes the emulated knob into a wall, from C# or Unity. It declares the few functions of torsio.h
// that it calls.
using System;
using System.Globalization;
using System.Runtime.InteropServices;

static class Torsio {
  const string Library = "torsio";  // libtorsio.so or torsio.dll, beside the program or where the system looks

  // struct_size comes first, and torsio_..._init fills it in. An enumeration is an int.
  [StructLayout(LayoutKind.Sequential)]
  public struct Wall {
    public uint StructSize;
    public double AngleRad;
    public int Side;
    public double StiffnessNmPerRad;
    public double DampingNmSPerRad;
  }

  [StructLayout(LayoutKind.Sequential)]
  public struct Knot {
    public double TimeS;
    public double Value;
  }

  [StructLayout(LayoutKind.Sequential)]
  public struct TorqueHand {
    public uint StructSize;
    public IntPtr TorqueNm;  // of Knots
    public UIntPtr TorqueNmCount;
  }

  [StructLayout(LayoutKind.Sequential)]
  public struct TelemetrySample {
    public ulong Tick;
    public double TimeS;
    public long PositionCounts;
    public double AngleRad;
    public float SpeedRadS;
    public float DesiredTorqueNm;
    public float MotorCommandNm;
    public float BrakeCapacityNm;
    public float SpringTorqueNm;
    public byte Flags;
  }

  [DllImport(Library)] public static extern IntPtr torsio_last_error();
  [DllImport(Library)] public static extern int torsio_wall_init(ref Wall wall);
  [DllImport(Library)] public static extern int torsio_torque_hand_init(ref TorqueHand hand);
  [DllImport(Library)] public static extern int torsio_knob_open(string selector, IntPtr options, out IntPtr knob);
  [DllImport(Library)] public static extern void torsio_knob_free(IntPtr knob);
  [DllImport(Library)] public static extern int torsio_knob_arm(IntPtr knob);
  [DllImport(Library)] public static extern int torsio_scene_new(out IntPtr scene);
  [DllImport(Library)] public static extern int torsio_scene_add_wall(IntPtr scene, ref Wall wall);
  [DllImport(Library)] public static extern void torsio_scene_free(IntPtr scene);
  [DllImport(Library)] public static extern int torsio_knob_play(IntPtr knob, IntPtr scene);
  [DllImport(Library)] public static extern int torsio_emulator_set_torque_hand(IntPtr knob, ref TorqueHand hand);
  [DllImport(Library)] public static extern int torsio_knob_start_telemetry(IntPtr knob, double rateHz, [MarshalAs(UnmanagedType.U1)] bool prompt, out double trueRateHz);
  [DllImport(Library)] public static extern int torsio_knob_read(
      IntPtr knob, [Out] TelemetrySample[] samples, UIntPtr capacity, UIntPtr itemSize, double timeoutS, out UIntPtr count);

  // A result that is not 0 as an exception, with the library's sentence.
  public static void Try(int result) {
    if (result != 0) throw new InvalidOperationException(Marshal.PtrToStringAnsi(torsio_last_error()));
  }
}

static class FeelAWall {
  static void PlayWall(IntPtr knob, double angleRad, double stiffnessNmPerRad) {
    var wall = new Torsio.Wall();
    Torsio.Try(Torsio.torsio_wall_init(ref wall));
    wall.AngleRad = angleRad;
    wall.StiffnessNmPerRad = stiffnessNmPerRad;
    IntPtr scene;
    Torsio.Try(Torsio.torsio_scene_new(out scene));
    try {
      Torsio.Try(Torsio.torsio_scene_add_wall(scene, ref wall));
      Torsio.Try(Torsio.torsio_knob_play(knob, scene));
    } finally {
      Torsio.torsio_scene_free(scene);
    }
  }

  static void Push(IntPtr knob) {
    var everHarder = new[] {
      new Torsio.Knot { TimeS = 0.0, Value = 0.0 }, new Torsio.Knot { TimeS = 1.0, Value = 0.05 }
    };
    var pinned = GCHandle.Alloc(everHarder, GCHandleType.Pinned);
    try {
      var hand = new Torsio.TorqueHand();
      Torsio.Try(Torsio.torsio_torque_hand_init(ref hand));
      hand.TorqueNm = pinned.AddrOfPinnedObject();
      hand.TorqueNmCount = (UIntPtr)everHarder.Length;
      Torsio.Try(Torsio.torsio_emulator_set_torque_hand(knob, ref hand));
    } finally {
      pinned.Free();
    }
  }

  static int Main() {
    IntPtr knob;
    Torsio.Try(Torsio.torsio_knob_open("emulated", IntPtr.Zero, out knob));
    try {
      PlayWall(knob, 0.1, 1.4);
      Push(knob);
      Torsio.Try(Torsio.torsio_knob_arm(knob));
      double rateHz;
      Torsio.Try(Torsio.torsio_knob_start_telemetry(knob, 0.0, false, out rateHz));

      var samples = new Torsio.TelemetrySample[4096];
      var itemSize = (UIntPtr)Marshal.SizeOf(typeof(Torsio.TelemetrySample));
      double furthestRad = 0.0, strongestNm = 0.0;
      for (int read = 0; read < 1.5 * rateHz;) {
        UIntPtr count;
        Torsio.Try(Torsio.torsio_knob_read(knob, samples, (UIntPtr)samples.Length, itemSize, 1.0, out count));
        for (int i = 0; i < (int)count; ++i) {
          furthestRad = Math.Max(furthestRad, samples[i].AngleRad);
          strongestNm = Math.Max(strongestNm, -(samples[i].SpringTorqueNm + samples[i].MotorCommandNm));
        }
        read += (int)count;
      }
      var invariant = CultureInfo.InvariantCulture;  // a point, wherever this runs
      Console.WriteLine(string.Format(invariant, "the knob was pushed to {0:F3} rad, into a wall at 0.1 rad,", furthestRad));
      Console.WriteLine("which pushed back with {0:F0} mN m", 1e3 * strongestNm);
      return 0;
    } finally {
      Torsio.torsio_knob_free(knob);
    }
  }
}

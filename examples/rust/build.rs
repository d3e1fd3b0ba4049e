// Lets bindgen, the program, print the declarations of the installed torsio.h, and links with its
// library. pkg-config says where both are.
use std::env;
use std::path::PathBuf;
use std::process::Command;

fn output_of(program: &str, arguments: &[&str]) -> String {
    let run = Command::new(program).args(arguments).output();
    let output = run.unwrap_or_else(|error| panic!("{program}: {error}"));
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{program} failed: {told}");
    String::from_utf8_lossy(&output.stdout).trim().to_string()
}

fn main() {
    let header = output_of("pkg-config", &["--variable=includedir", "torsio-c"]) + "/torsio.h";
    let library = output_of("pkg-config", &["--variable=libdir", "torsio-c"]);
    let declarations = PathBuf::from(env::var("OUT_DIR").unwrap()).join("torsio.rs");
    // bindgen brings Clang's library without its headers; GCC's stdbool.h serves as well.
    let compilers = output_of("gcc", &["-print-file-name=include"]);
    output_of(
        "bindgen",
        &[
            "--allowlist-function", "torsio_.*", "--allowlist-type", "torsio_.*",
            "--allowlist-var", "TORSIO_.*", "-o", declarations.to_str().unwrap(), &header,
            "--", "-idirafter", &compilers,
        ],
    );
    println!("cargo:rerun-if-changed={header}");
    println!("cargo:rerun-if-env-changed=PKG_CONFIG_PATH");
    println!("cargo:rustc-link-search=native={library}");
    println!("cargo:rustc-link-lib=torsio");
}

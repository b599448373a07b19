/// `bsoil`: experiments and regression tests with deformable soil from the command line.
#include <CLI/CLI.hpp>
#include <iostream>
#include <new>

#include "bsoil/version.h"
#include "command_line.h"
#include "commands.h"

int main(int argument_count, char** arguments) {
    CLI::App app{"BulletSoil: deformable soil for the Bullet physics library", "bsoil"};
    app.require_subcommand(1);
    app.set_version_flag("--version", bsoil::version());
    app.set_help_all_flag("--help-all", "help of all commands");
    int exit_code = bsoil::command::kPassed;
    bsoil::command::add_run(app, exit_code);
    bsoil::command::add_view(app, exit_code);
    bsoil::command::add_render(app, exit_code);
    bsoil::command::add_export(app, exit_code);
    bsoil::command::add_check(app, exit_code);
    bsoil::command::add_experiments(app, exit_code);
    bsoil::command::add_validate(app, exit_code);
    bsoil::command::add_info(app, exit_code);
    bsoil::command::add_bench(app, exit_code);
    bsoil::command::add_import_bekker(app, exit_code);
    bsoil::command::add_scene_keys(app, exit_code);
    const std::string unknown = bsoil::command::unknown_word(app, argument_count, arguments);
    if (!unknown.empty()) {
        std::cerr << unknown << '\n';
        return bsoil::command::kCouldNotRun;
    }
    try {
        app.parse(argument_count, arguments);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? bsoil::command::kPassed : bsoil::command::kCouldNotRun;
    } catch (const std::bad_alloc&) {
        std::cerr << "bsoil: the memory of this machine is full; lower `size_m` of [soil], or "
                     "raise `voxel_m`\n";
        return bsoil::command::kCouldNotRun;
    } catch (const std::exception& error) {
        std::cerr << "bsoil: " << error.what() << '\n';
        return bsoil::command::kCouldNotRun;
    }
    return exit_code;
}
